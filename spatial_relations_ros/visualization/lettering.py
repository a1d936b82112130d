"""Text in pictures, in a font that every installation has: the one that matplotlib ships."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Literal

import matplotlib
import numpy as np
from PIL import Image as PillowImage
from PIL import ImageDraw, ImageFont

from spatial_relations_ros.visualization.images import Image
from spatial_relations_ros.visualization.palette import INK, Rgb, as_bytes

Anchor = Literal['lm', 'mm', 'rm', 'ls', 'ms']
"""Which point of the text is placed: left, middle, right; m is its middle, s its baseline."""


@functools.lru_cache(maxsize=16)
def _font(size: int, bold: bool) -> ImageFont.FreeTypeFont:
    name = 'DejaVuSans-Bold.ttf' if bold else 'DejaVuSans.ttf'
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / 'fonts' / 'ttf' / name), size)


def letter(
    image: Image,
    text: str,
    position: tuple[float, float],
    *,
    size: int = 15,
    colour: Rgb = INK,
    bold: bool = False,
    anchor: Anchor = 'lm',
) -> None:
    """Writes one line of text into a picture, in place.

    Args:
        image: (H, W, 3) uint8 RGB.
        text: what does not fit is cut off at the picture's edge.
        position: column, row of the anchor, pixels.
        size: of the font, pixels.
        colour: of the text.
        bold: whether to use the bold face.
        anchor: which point of the text ``position`` is.
    """
    canvas = PillowImage.fromarray(image)
    ImageDraw.Draw(canvas).text(
        position,
        text,
        font=_font(size, bold),
        fill=tuple(as_bytes(colour).tolist()),
        anchor=anchor,
    )
    image[:] = np.asarray(canvas)


def text_width(text: str, *, size: int = 15, bold: bool = False) -> float:
    """Width in pixels of a line of text."""
    return float(_font(size, bold).getlength(text))


def shortened(text: str, max_width: float, *, size: int = 15, bold: bool = False) -> str:
    """The text, or as much of its beginning as fits, with an ellipsis."""
    if text_width(text, size=size, bold=bold) <= max_width:
        return text
    kept = text
    while kept and text_width(kept + '…', size=size, bold=bold) > max_width:
        kept = kept[:-1]
    return kept.rstrip() + '…'
