"""Curves over steps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.visualization.diagrams import (
    DPI,
    count_by_whole_numbers,
    new_figure,
    picture_of,
)
from spatial_relations_ros.visualization.images import Image
from spatial_relations_ros.visualization.palette import (
    BASE_COLOUR,
    FADED_INK,
    FRAME,
    INK,
    RELATIVE_COLOUR,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NEAREST_WHILE_SEARCHING = 'Nearest found while searching'


def draw_distance_curve(
    history: NDArray[np.floating] | Sequence[float],
    *,
    title: str = NEAREST_WHILE_SEARCHING,
    width: int = 800,
    height: int = 480,
    cursor: float | None = None,
    steps: str = 'step',
) -> Image:
    """The distance under the metric over the optimiser's steps.

    While an imitation searches it is that of the nearest placement so far, feasible or not: the
    answer, which must be feasible, may be farther away.

    Args:
        history: (S,) distances; the first is the scene as it stood. May be empty, may hold NaN.
        title: above the curve.
        width: pixels.
        height: pixels.
        cursor: a step, between two as well, that is marked; none by default.
        steps: what the steps are.

    Returns:
        (height, width, 3) uint8 RGB.
    """
    distances = np.asarray(history, dtype=np.float64).reshape(-1)
    figure, axes = _axes_over_steps('distance', steps, title=title, size=(width, height))
    if np.isfinite(distances).any():
        _curve(axes, distances)
        if cursor is not None:
            level = float(np.interp(cursor, np.arange(len(distances)), distances))
            axes.axvline(cursor, color=RELATIVE_COLOUR, linewidth=1.5)
            axes.plot(cursor, level, 'o', color=RELATIVE_COLOUR, markersize=8, clip_on=False)
    else:
        axes.text(
            0.5, 0.5, 'no steps were made', transform=axes.transAxes, ha='center', color=FADED_INK
        )
    return picture_of(figure)


def draw_loss_curve(
    losses: NDArray[np.floating] | Sequence[float],
    *,
    title: str = 'Training loss',
    width: int = 800,
    height: int = 480,
) -> Image:
    """The loss over training steps, and its running mean.

    Args:
        losses: (S,), one for each step; may be empty.
        title: above the curve.
        width: pixels.
        height: pixels.

    Returns:
        (height, width, 3) uint8 RGB.
    """
    values = np.asarray(losses, dtype=np.float64).reshape(-1)
    figure, axes = _axes_over_steps('loss', 'step', title=title, size=(width, height))
    steps = np.arange(1, len(values) + 1)
    axes.plot(steps, values, color=BASE_COLOUR, linewidth=0.8, alpha=0.35)
    window = max(1, len(values) // 50)
    if len(values) >= window:
        mean = np.convolve(values, np.full(window, 1.0 / window), mode='valid')
        axes.plot(steps[window - 1 :], mean, color=BASE_COLOUR, linewidth=2.0)
    if np.isfinite(values).any():
        axes.set_ylim(0.0, 1.1 * float(np.nanpercentile(values, 99.5)) or 1.0)
    count_by_whole_numbers(axes)
    return picture_of(figure)


def _axes_over_steps(
    quantity: str, steps: str, *, title: str, size: tuple[int, int]
) -> tuple[Figure, Axes]:
    """An empty diagram of a quantity over steps; size is width and height in pixels."""
    figure = new_figure((size[0] / DPI, size[1] / DPI))
    axes = figure.add_subplot()
    axes.set_title(title, loc='left', fontsize=11, color=INK, fontweight='bold', pad=10)
    axes.set_xlabel(steps, color=FADED_INK)
    axes.set_ylabel(quantity, color=FADED_INK)
    _plain(axes)
    return figure, axes


def _plain(axes: Axes) -> None:
    axes.grid(color=FRAME, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.tick_params(colors=FADED_INK, length=0)
    for side in ('top', 'right'):
        axes.spines[side].set_visible(False)
    for side in ('left', 'bottom'):
        axes.spines[side].set_color(FRAME)


def _curve(axes: Axes, distances: NDArray[np.float64]) -> None:
    steps = np.arange(len(distances))
    best = int(np.nanargmin(distances))
    start = int(np.flatnonzero(np.isfinite(distances))[0])
    axes.plot(steps, distances, color=BASE_COLOUR, linewidth=2.0)
    axes.fill_between(steps, distances, 0.0, color=BASE_COLOUR, alpha=0.10, linewidth=0.0)
    top = 1.12 * float(np.nanmax(distances)) or 1.0
    axes.set_ylim(0.0, top)
    axes.set_xlim(0, max(len(distances) - 1, 1))
    count_by_whole_numbers(axes)
    for step, words, shift in ((start, 'start', 8), (best, 'least', 10)):
        axes.plot(step, distances[step], 'o', color=BASE_COLOUR, markersize=6, clip_on=False)
        late = step > 0.8 * len(distances)
        axes.annotate(
            f'{words} {distances[step]:.3f}',
            (step, distances[step]),
            xytext=(-6 if late else 8, shift),
            textcoords='offset points',
            ha='right' if late else 'left',
            fontsize=9,
            color=INK,
        )
        if start == best:
            break
