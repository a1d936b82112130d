"""The colours of all pictures: one for the base, one for the relative, everywhere."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Rgb = tuple[float, float, float]
"""A colour, sRGB, 0 to 1 a channel."""

BASE_COLOUR: Rgb = (0.27, 0.47, 0.69)
RELATIVE_COLOUR: Rgb = (0.93, 0.49, 0.13)
# Drawn by position: base, relative, then anything else.
OBJECT_COLOURS: tuple[Rgb, ...] = (
    BASE_COLOUR,
    RELATIVE_COLOUR,
    (0.35, 0.62, 0.36),
    (0.62, 0.42, 0.67),
    (0.72, 0.62, 0.30),
    (0.40, 0.65, 0.68),
)

PAPER: Rgb = (1.0, 1.0, 1.0)
INK: Rgb = (0.13, 0.15, 0.18)
FADED_INK: Rgb = (0.42, 0.45, 0.50)
FRAME: Rgb = (0.83, 0.85, 0.88)

TABLE: Rgb = (0.905, 0.912, 0.920)
HORIZON: Rgb = (0.955, 0.962, 0.972)


def as_bytes(colour: Rgb) -> NDArray[np.uint8]:
    """The colour as (3,) uint8."""
    return np.round(np.asarray(colour) * 255.0).astype(np.uint8)


def linear_from_srgb(colour: Rgb | NDArray[np.float32]) -> NDArray[np.float32]:
    """Light (..., 3) of sRGB colours, IEC 61966-2-1, approximated by a power of 2.2."""
    return np.power(np.clip(np.asarray(colour, dtype=np.float32), 0.0, 1.0), np.float32(2.2))


def bytes_from_linear(light: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Inverse of :func:`linear_from_srgb`, clipped, as bytes."""
    levels = len(_BYTES_OF_LIGHT) - 1
    return _BYTES_OF_LIGHT[(np.clip(light, 0.0, 1.0) * levels + 0.5).astype(np.uint16)]


# A table is ten times faster than the power; dark values need the finer steps.
_BYTES_OF_LIGHT = np.round(np.linspace(0.0, 1.0, 1 << 16) ** (1.0 / 2.2) * 255.0).astype(np.uint8)

# The seven relations, by their labels: told apart also by the colour-blind (after Okabe and Ito).
RELATION_COLOURS: tuple[Rgb, ...] = (
    (0.00, 0.45, 0.70),
    (0.84, 0.37, 0.00),
    (0.00, 0.62, 0.45),
    (0.80, 0.47, 0.65),
    (0.34, 0.71, 0.91),
    (0.90, 0.62, 0.00),
    (0.45, 0.45, 0.45),
)
RIGHT: Rgb = (0.20, 0.60, 0.32)
WRONG: Rgb = (0.80, 0.18, 0.18)
