"""Quantities over time, one diagram below the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.visualization.diagrams import DPI, new_figure, picture_of
from spatial_relations_ros.visualization.images import Image
from spatial_relations_ros.visualization.palette import (
    BASE_COLOUR,
    FADED_INK,
    FRAME,
    INK,
    OBJECT_COLOURS,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class Curve:
    """One quantity.

    Attributes:
        name: in the legend.
        times: (N,) seconds, as recorded.
        values: (N,); None or NaN where it is not known.
        is_line: a line, or dots.
    """

    name: str
    times: Sequence[float]
    values: Sequence[float | None]
    is_line: bool = True


@dataclass(frozen=True)
class Timeline:
    """One diagram.

    Attributes:
        title: above it.
        quantity: of the curves.
        curves: what is drawn.
        spans: (start, end) of times that are shaded, seconds.
    """

    title: str
    quantity: str
    curves: tuple[Curve, ...]
    spans: tuple[tuple[float, float], ...] = ()


def draw_timelines(timelines: Sequence[Timeline], *, width: int = 1000, rows: int = 260) -> Image:
    """Draws diagrams with a common axis of time.

    Args:
        timelines: from top to bottom, at least one.
        width: pixels.
        rows: pixels of each diagram.

    Returns:
        (rows * N, width, 3) uint8 RGB.

    Raises:
        ConfigError: without a timeline.
    """
    if not timelines:
        raise ConfigError('there is no timeline to draw')
    size = width / DPI, rows * len(timelines) / DPI
    figure = new_figure(size)
    panels = figure.subplots(len(timelines), 1, sharex=True, squeeze=False)[:, 0]
    for axes, timeline in zip(panels, timelines, strict=True):
        _draw(axes, timeline)
    panels[-1].set_xlabel('seconds after the first cloud', color=FADED_INK)
    return picture_of(figure)


def _draw(axes: Axes, timeline: Timeline) -> None:
    for start, end in timeline.spans:
        axes.axvspan(start, end, color=BASE_COLOUR, alpha=0.10, linewidth=0.0)
    for idx, curve in enumerate(timeline.curves):
        values = np.array([np.nan if value is None else value for value in curve.values])
        style = '-' if curve.is_line else 'o'
        colour = OBJECT_COLOURS[idx % len(OBJECT_COLOURS)]
        axes.plot(curve.times, values, style, color=colour, linewidth=1.8, label=curve.name)
    axes.set_title(timeline.title, loc='left', fontsize=10, color=INK, fontweight='bold')
    axes.set_ylabel(timeline.quantity, color=FADED_INK)
    axes.set_ylim(bottom=0.0)
    axes.grid(color=FRAME, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.tick_params(colors=FADED_INK, length=0)
    for side in ('top', 'right', 'left', 'bottom'):
        axes.spines[side].set_visible(False)
    if timeline.curves:
        axes.legend(fontsize=8, frameon=False, loc='center left', bbox_to_anchor=(1.0, 0.5))
