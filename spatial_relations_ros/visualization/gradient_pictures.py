"""How the error changes with the images and with the points: the projection's gradients drawn."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.visualization.images import Image
from spatial_relations_ros.visualization.palette import (
    BASE_COLOUR,
    FADED_INK,
    FRAME,
    INK,
    RELATIVE_COLOUR,
)
from spatial_relations_ros.visualization.projections import PLANE_AXES, PLANE_TITLES

DPI = 100
NUM_ARROWS = 120
# Of the cube's side: the longest arrow.
_ARROW_LENGTH = 0.16
_AXIS = {'x': 0, 'y': 1, 'z': 2}


def draw_gradients(
    points: NDArray[np.floating],
    by_images: NDArray[np.floating],
    by_points: Mapping[str, NDArray[np.floating]],
    *,
    seed: int = 0,
) -> Image:
    """A row for the gradient by the relative's images, and one for each way to carry it to points.

    In the images red rises the error where depth grows, and blue lowers it. Arrows show where a
    step of descent moves points of the relative; in each row the longest tenth are equally long.

    Args:
        points: (2, N, 3) base and relative in the unit cube.
        by_images: (3, 2, S, S) gradient of the error by the images.
        by_points: (2, N, 3) gradient of the error by the points, by name.
        seed: of which points get arrows.

    Returns:
        (H, 900, 3) uint8 RGB.

    Raises:
        ConfigError: for arrays that do not fit together.
    """
    points, by_images = np.asarray(points), np.asarray(by_images)
    shapes = {np.shape(gradient) for gradient in by_points.values()}
    if by_images.shape[:2] != (3, 2) or not shapes or shapes != {points.shape}:
        raise ConfigError(
            f'gradients by images (3, 2, S, S) and by points {points.shape} are needed, got '
            f'{by_images.shape} and {sorted(shapes)}'
        )
    rows = 1 + len(by_points)
    figure = Figure(figsize=(9.0, 3.1 * rows), dpi=DPI, layout='constrained')
    canvas = FigureCanvasAgg(figure)
    grid = figure.subplots(rows, 3, squeeze=False)
    limit = float(np.abs(by_images[:, 1]).max()) or 1.0
    for plane_idx, axes in enumerate(grid[0]):
        _frame(axes, plane_idx, PLANE_TITLES[plane_idx])
        axes.imshow(
            by_images[plane_idx, 1], cmap='RdBu_r', vmin=-limit, vmax=limit, origin='lower',
            extent=(0.0, 1.0, 0.0, 1.0),
        )  # fmt: skip
    grid[0][0].set_ylabel("U': error by depth", color=INK)
    rng = np.random.default_rng(seed)
    for axes_of_row, (name, gradient) in zip(grid[1:], by_points.items(), strict=True):
        chosen = _with_arrows(gradient[1], rng)
        for plane_idx, axes in enumerate(axes_of_row):
            _frame(axes, plane_idx, '')
            _arrows(axes, plane_idx, points, -gradient[1], chosen)
        axes_of_row[0].set_ylabel(name, color=INK)
    canvas.draw()
    return np.ascontiguousarray(np.asarray(canvas.buffer_rgba())[..., :3])


def _with_arrows(gradient: NDArray[np.floating], rng: np.random.Generator) -> NDArray[np.int64]:
    """Rows of points that the error depends on, drawn evenly among them."""
    felt = np.flatnonzero(np.linalg.norm(gradient, axis=1) > 0.0)
    count = min(NUM_ARROWS, len(felt))
    return np.sort(rng.choice(felt, count, replace=False)) if count else felt


def _arrows(
    axes: Axes,
    plane_idx: int,
    points: NDArray[np.floating],
    descent: NDArray[np.floating],
    chosen: NDArray[np.int64],
) -> None:
    across, upward = (_AXIS[name] for name in PLANE_AXES[plane_idx])
    for cloud, colour in zip(points, (BASE_COLOUR, RELATIVE_COLOUR), strict=True):
        axes.scatter(cloud[:, across], cloud[:, upward], s=1.0, color=colour, alpha=0.25)
    lengths = np.linalg.norm(descent[chosen], axis=1)
    longest = float(np.quantile(lengths, 0.9)) if len(lengths) else 1.0
    steps = descent[chosen] / np.maximum(np.maximum(lengths, longest), 1e-30)[:, None]
    steps = _ARROW_LENGTH * steps[:, [across, upward]]
    axes.quiver(
        points[1][chosen, across], points[1][chosen, upward],
        *steps.T,
        angles='xy', scale_units='xy', scale=1.0, width=0.005, color=INK,
    )  # fmt: skip


def _frame(axes: Axes, plane_idx: int, title: str) -> None:
    across, upward = PLANE_AXES[plane_idx]
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(0.0, 1.0)
    axes.set_aspect('equal')
    axes.set_xticks([])
    axes.set_yticks([])
    axes.set_title(title, loc='left', fontsize=11, color=INK, fontweight='bold')
    axes.set_title(f'{across} →   {upward} ↑', loc='right', fontsize=9, color=FADED_INK)
    for spine in axes.spines.values():
        spine.set_color(FRAME)
