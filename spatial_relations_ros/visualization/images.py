"""Pictures as arrays, and writing them."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError, atomic_write

Image = NDArray[np.uint8]
"""A picture (H, W, 3), RGB in sRGB, 0 to 255."""


def png_bytes(image: Image) -> bytes:
    """A picture as PNG.

    Args:
        image: (H, W, 3) uint8 RGB.

    Raises:
        ConfigError: for an array that is no picture.
    """
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3 or image.size == 0:
        raise ConfigError(f'a picture is (H, W, 3) uint8, got {image.shape} {image.dtype}')
    encoded, data = cv2.imencode('.png', np.ascontiguousarray(image[..., ::-1]))
    if not encoded:
        raise ConfigError(f'the picture {image.shape} cannot be encoded as PNG')
    return bytes(data.tobytes())


def write_image(path: Path | str, image: Image) -> Path:
    """Writes a picture as PNG; a crash never leaves half of one.

    Args:
        path: where to; missing folders are made.
        image: (H, W, 3) uint8 RGB.

    Returns:
        The path written.

    Raises:
        ConfigError: for another suffix than ``.png`` or an array that is no picture.
    """
    path = Path(path)
    if path.suffix.lower() != '.png':
        raise ConfigError(f'pictures are written as .png, got {path.name!r}')
    data = png_bytes(image)
    with atomic_write(path) as temporary:
        temporary.write_bytes(data)
    return path


def read_image(path: Path | str) -> Image:
    """Reads a picture as (H, W, 3) uint8 RGB.

    Raises:
        ConfigError: when the file is missing or no picture.
    """
    image = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if image is None:
        raise ConfigError(f'{path} is not a picture that can be read')
    return np.ascontiguousarray(image[..., ::-1], dtype=np.uint8)
