"""Pictures as coloured text, for terminals without a display."""

from __future__ import annotations

import cv2
import numpy as np

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.visualization.images import Image

UPPER_HALF = '\u2580'
RESET = '\x1b[0m'


def terminal_picture(image: Image, *, columns: int = 80) -> str:
    """The picture in 24-bit colours, two pixels a character above each other.

    Args:
        image: (H, W, 3) uint8 RGB.
        columns: width of the text, characters.

    Raises:
        ConfigError: for no columns.
    """
    if columns < 1:
        raise ConfigError(f'a picture needs columns, got {columns}')
    rows = 2 * max(1, round(image.shape[0] * columns / image.shape[1] / 2.0))
    small = cv2.resize(image, (columns, rows), interpolation=cv2.INTER_AREA)
    lines = []
    for upper, lower in zip(small[::2], small[1::2], strict=True):
        pairs = np.concatenate([upper, lower], axis=1).tolist()
        cells = (
            f'\x1b[38;2;{r};{g};{b};48;2;{s};{h};{c}m{UPPER_HALF}' for r, g, b, s, h, c in pairs
        )
        lines.append(''.join(cells) + RESET)
    return '\n'.join(lines)
