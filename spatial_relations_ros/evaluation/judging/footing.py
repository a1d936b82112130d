"""How an object's foot lies on what carries it: reaches and overhangs, seen from above."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_NUM_DIRECTIONS = 36
_FOOT_BAND = 0.003


@dataclass(frozen=True)
class Footing:
    """A foot on its carrier.

    Attributes:
        overhang: the largest reach of the foot beyond the carrier, as a share of the foot's width
            in that direction; negative when the foot lies within.
        opposite_overhang: the same on the opposite side.
        off_centre: distance of the foot's middle from the carrier's, in the direction of the
            overhang, as a share of the smaller of both widths.
        overhang_metres: the reach itself.
    """

    overhang: float
    opposite_overhang: float
    off_centre: float
    overhang_metres: float


def footing_of(
    base_points: FloatArray, relative_points: FloatArray, *, down: FloatArray, gap: float
) -> Footing | None:
    """Compares the lowest level of the relative with the base from that height upwards.

    Args:
        base_points: (N, 3) of the surface, world, z up.
        relative_points: (M, 3).
        down: (3,) towards the face on which the relative stands; vertical but for a small tilt.
        gap: within which surfaces count as touching, metres.

    Returns:
        None when nothing of the base reaches up to the relative.
    """
    bottom = float(relative_points[:, 2].min())
    carrier = base_points[base_points[:, 2] > bottom - 2.0 * gap, :2]
    if len(carrier) < 3:
        return None
    depth = relative_points @ down
    foot = relative_points[depth > depth.max() - _FOOT_BAND, :2]
    angles = np.arange(_NUM_DIRECTIONS) * (2.0 * np.pi / _NUM_DIRECTIONS)
    directions = np.stack([np.cos(angles), np.sin(angles)])
    foot_reach, carrier_reach = (foot @ directions).max(axis=0), (carrier @ directions).max(axis=0)
    foot_width = foot_reach + _opposite(foot_reach)
    carrier_width = carrier_reach + _opposite(carrier_reach)
    beyond = foot_reach - carrier_reach
    share = beyond / np.maximum(foot_width, 1e-4)
    # One-sided overhangs count most: a board on a can hangs over everywhere.
    worst = int(np.argmax(share - np.maximum(_opposite(share), 0.0)))
    off_centre = 0.5 * (beyond - _opposite(beyond)) / np.minimum(foot_width, carrier_width)
    return Footing(
        overhang=float(share[worst]),
        opposite_overhang=float(_opposite(share)[worst]),
        off_centre=float(off_centre[worst]),
        overhang_metres=float(beyond[worst]),
    )


def _opposite(values: FloatArray) -> FloatArray:
    return np.roll(values, _NUM_DIRECTIONS // 2)
