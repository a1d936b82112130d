"""Diagrams as pictures, drawn by matplotlib without a display.

matplotlib is imported by the first diagram: it takes a second, and nodes draw none.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from spatial_relations_ros.visualization.images import Image

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DPI = 120


def new_figure(
    size: tuple[float, float], *, layout: Literal['constrained'] | None = 'constrained'
) -> Figure:
    """An empty figure of a width and a height in inches, ``DPI`` pixels each."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, dpi=DPI, layout=layout)
    FigureCanvasAgg(figure)
    return figure


def picture_of(figure: Figure) -> Image:
    """What a figure shows."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas = figure.canvas
    assert isinstance(canvas, FigureCanvasAgg)
    canvas.draw()
    return np.ascontiguousarray(np.asarray(canvas.buffer_rgba())[..., :3])


def count_by_whole_numbers(axes: Axes) -> None:
    """Marks whole numbers only along x."""
    from matplotlib.ticker import MaxNLocator

    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
