"""The six depth images that the network sees, as one labelled picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import matplotlib
import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.visualization.images import Image
from spatial_relations_ros.visualization.lettering import letter, shortened
from spatial_relations_ros.visualization.palette import (
    BASE_COLOUR,
    FADED_INK,
    FRAME,
    PAPER,
    RELATIVE_COLOUR,
    as_bytes,
)

PLANE_TITLES = ('top', 'front', 'side')
# What grows to the right and upwards in each plane.
PLANE_AXES = (('x', 'y'), ('x', 'z'), ('y', 'z'))
CHANNEL_TITLES = ('base', 'relative')
COLOUR_MAP = 'viridis_r'
NEAREST = 100.0
FARTHEST = 200.0


@dataclass(frozen=True)
class ProjectionLayout:
    """Where each image lies in the picture, pixels.

    Attributes:
        cell: side of an image.
        gap: between images.
        left: free columns at the left, for the channels' names.
        top: free rows at the top, for the planes' names.
        right: free columns at the right, for the depth scale.
        bottom: free rows at the bottom.
    """

    cell: int
    gap: int = 16
    left: int = 44
    top: int = 52
    right: int = 92
    bottom: int = 34

    def corner(self, plane_idx: int, channel_idx: int) -> tuple[int, int]:
        """Row and column of an image's upper left pixel."""
        step = self.cell + self.gap
        return self.top + channel_idx * step, self.left + plane_idx * step

    @property
    def shape(self) -> tuple[int, int, int]:
        """Of the whole picture."""
        step = self.cell + self.gap
        height = self.top + 2 * step - self.gap + self.bottom
        return height, self.left + 3 * step - self.gap + self.right, 3


def projection_layout(image_size: int, cell: int = 240) -> ProjectionLayout:
    """The layout for images of that many pixels; each becomes a whole number of pixels."""
    return ProjectionLayout(image_size * max(1, round(cell / image_size)))


def draw_projections(
    images: NDArray[np.floating], *, object_ids: Sequence[str] = (), cell: int = 240
) -> Image:
    """The depth images of a scene in a grid: planes in columns, objects in rows.

    Near is bright, far is dark, an empty pixel is white. World axes are written at each image;
    z points up.

    Args:
        images: (3, 2, S, S) planes top, front, side; channels base, relative; 0 is empty, 100
            the image plane, 200 the far side of the unit cube; rows grow upwards in the world.
        object_ids: of base and relative, written beside the rows.
        cell: wanted side of an image in the picture, pixels.

    Returns:
        (H, W, 3) uint8 RGB.

    Raises:
        ConfigError: for another shape.
    """
    images = checked_images(images)
    layout = projection_layout(images.shape[-1], cell)
    picture = projection_grid(layout, _coloured(images), object_ids)
    ramp = np.linspace(NEAREST, FARTHEST, 256, dtype=np.float32)
    draw_scale(picture, layout, _coloured(ramp), ('near', 'depth', 'far'))
    return picture


def checked_images(images: NDArray[np.floating]) -> NDArray[np.float32]:
    """The images as float32.

    Raises:
        ConfigError: when their shape is not (3, 2, S, S).
    """
    images = np.asarray(images, dtype=np.float32)
    if images.ndim != 4 or images.shape[:2] != (3, 2) or images.shape[2] != images.shape[3]:
        raise ConfigError(f'projections have the shape (3, 2, S, S), got {images.shape}')
    return images


def projection_grid(
    layout: ProjectionLayout, coloured: NDArray[np.uint8], object_ids: Sequence[str] = ()
) -> Image:
    """Six pictures (3, 2, S, S, 3) with titles; their rows grow upwards in the world."""
    picture = np.empty(layout.shape, dtype=np.uint8)
    picture[:] = as_bytes(PAPER)
    for plane_idx in range(3):
        for channel_idx in range(2):
            row, column = layout.corner(plane_idx, channel_idx)
            _frame(picture, row, column, layout.cell, layout.cell)
            picture[row : row + layout.cell, column : column + layout.cell] = cv2.resize(
                np.ascontiguousarray(coloured[plane_idx, channel_idx, ::-1]),
                (layout.cell, layout.cell),
                interpolation=cv2.INTER_NEAREST,
            )
    _titles(picture, layout, object_ids)
    return picture


def _coloured(image: NDArray[np.float32]) -> Image:
    share = np.clip((image - NEAREST) / (FARTHEST - NEAREST), 0.0, 1.0)
    coloured = matplotlib.colormaps[COLOUR_MAP](share, bytes=True)[..., :3]
    return np.where((image > 0.0)[..., None], coloured, as_bytes(PAPER)).astype(np.uint8)


def _frame(picture: Image, row: int, column: int, height: int, width: int) -> None:
    picture[row - 1 : row + height + 1, column - 1 : column + width + 1] = as_bytes(FRAME)


def _titles(picture: Image, layout: ProjectionLayout, object_ids: Sequence[str]) -> None:
    for plane_idx, (title, (across, upward)) in enumerate(
        zip(PLANE_TITLES, PLANE_AXES, strict=True)
    ):
        row, column = layout.corner(plane_idx, 0)
        letter(picture, title, (column, row - 22), size=17, bold=True)
        letter(
            picture,
            f'{across} →   {upward} ↑',
            (column + layout.cell, row - 22),
            size=14,
            colour=FADED_INK,
            anchor='rm',
        )
    for channel_idx, (title, colour) in enumerate(
        zip(CHANNEL_TITLES, (BASE_COLOUR, RELATIVE_COLOUR), strict=True)
    ):
        row, _ = layout.corner(0, channel_idx)
        if len(object_ids) == 2:
            title = f'{title}: {object_ids[channel_idx]}'
        banner = np.empty((layout.left - 8, layout.cell, 3), dtype=np.uint8)
        banner[:] = as_bytes(PAPER)
        letter(
            banner,
            shortened(title, layout.cell, size=16, bold=True),
            (layout.cell / 2, banner.shape[0] / 2),
            size=16,
            bold=True,
            colour=colour,
            anchor='mm',
        )
        picture[row : row + layout.cell, : banner.shape[0]] = np.rot90(banner)


def draw_scale(
    picture: Image, layout: ProjectionLayout, ramp: NDArray[np.uint8], words: tuple[str, str, str]
) -> None:
    """A scale of colours (K, 3) at the right edge, the first at the top, with three words."""
    row, column = layout.corner(2, 0)
    height = 2 * layout.cell + layout.gap
    column += layout.cell + 22
    _frame(picture, row, column, height, 16)
    rows = np.linspace(0, len(ramp) - 1, height).round().astype(int)
    picture[row : row + height, column : column + 16] = ramp[rows][:, None]
    for share, text in zip((0.0, 0.5, 1.0), words, strict=True):
        place = row + np.clip(share * height, 7, height - 7)
        letter(picture, text, (column + 23, place), size=13, colour=FADED_INK)
