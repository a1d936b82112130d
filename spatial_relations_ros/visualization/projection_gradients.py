"""Gradients at the six depth images, as in the figures of Jund et al. 2018."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import matplotlib
import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.visualization.images import Image
from spatial_relations_ros.visualization.palette import INK, as_bytes
from spatial_relations_ros.visualization.projections import (
    ProjectionLayout,
    checked_images,
    draw_scale,
    projection_grid,
    projection_layout,
)

COLOUR_MAP = 'RdBu_r'
# Single pixels stick out: this share of them sets the colours' range.
RANGE_PERCENTILE = 99.5
SILHOUETTE_SHADE = 0.90
ARROWS_A_SIDE = 10


def draw_projection_gradients(
    images: NDArray[np.floating],
    by_images: NDArray[np.floating],
    descent: NDArray[np.floating],
    *,
    object_ids: Sequence[str] = (),
    cell: int = 240,
) -> Image:
    """The gradients of a distance at a scene's images in a grid: planes, and base and relative.

    Red pixels raise the distance where they get farther, blue ones where they get nearer; grey is
    where the object is. Arrows show where the points are to move, longest in the whole picture for
    the largest gradient of a tenth of an image's side.

    Args:
        images: (3, 2, S, S) as for :func:`draw_projections`.
        by_images: (3, 2, S, S) of the distance by the images' values.
        descent: (3, 2, S, S, 2) minus the gradient by points, summed a pixel, along columns and
            rows.
        object_ids: of base and relative.
        cell: wanted side of an image in the picture, pixels.

    Returns:
        (H, W, 3) uint8 RGB.

    Raises:
        ConfigError: for other shapes.
    """
    images, by_images = checked_images(images), checked_images(by_images)
    descent = np.asarray(descent, dtype=np.float32)
    if by_images.shape != images.shape or descent.shape != (*images.shape, 2):
        raise ConfigError(
            f'images {images.shape}, gradients {by_images.shape} and arrows {descent.shape} do '
            'not fit: expected (3, 2, S, S) twice and (3, 2, S, S, 2)'
        )
    layout = projection_layout(images.shape[-1], cell)
    shades = np.where(images > 0.0, SILHOUETTE_SHADE, 1.0)[..., None]
    ramp = _coloured(np.linspace(1.0, -1.0, 256, dtype=np.float32))
    limit = max(float(np.percentile(np.abs(by_images), RANGE_PERCENTILE)), 1e-12)
    coloured = (_coloured(by_images / limit) * shades).astype(np.uint8)
    picture = projection_grid(layout, coloured, object_ids)
    draw_scale(picture, layout, ramp, ('raises', '0', 'lowers'))
    _draw_arrows(picture, layout, descent)
    return picture


def _coloured(shares: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Colours of -1 to 1."""
    colours = matplotlib.colormaps[COLOUR_MAP](np.clip(0.5 + 0.5 * shares, 0.0, 1.0), bytes=True)
    return np.asarray(colours[..., :3])


def _draw_arrows(picture: Image, layout: ProjectionLayout, descent: NDArray[np.float32]) -> None:
    size = descent.shape[2]
    step = max(1, size // ARROWS_A_SIDE)
    used = size // step * step
    blocks = descent[:, :, :used, :used].reshape(3, 2, used // step, step, used // step, step, 2)
    sums = blocks.sum(axis=(3, 5))
    longest = float(np.linalg.norm(sums, axis=-1).max())
    if longest <= 0.0:
        return
    pixel = layout.cell / size
    for plane_idx, channel_idx, row_idx, column_idx in np.argwhere(
        np.linalg.norm(sums, axis=-1) > 0.08 * longest
    ):
        row, column = layout.corner(plane_idx, channel_idx)
        across, upward = sums[plane_idx, channel_idx, row_idx, column_idx] / longest
        start = np.array(
            [
                column + (column_idx + 0.5) * step * pixel,
                row + layout.cell - (row_idx + 0.5) * step * pixel,
            ]
        )
        end = start + 1.6 * step * pixel * np.array([across, -upward])
        cv2.arrowedLine(
            picture,
            tuple(np.round(start).astype(int).tolist()),
            tuple(np.round(end).astype(int).tolist()),
            as_bytes(INK).tolist(),
            1,
            cv2.LINE_AA,
            tipLength=0.35,
        )
