"""Maps of many scenes in two dimensions, coloured by relation, with some scenes shown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError, Relation
from spatial_relations_ros.visualization.diagrams import new_figure, picture_of
from spatial_relations_ros.visualization.images import Image
from spatial_relations_ros.visualization.palette import FADED_INK, FRAME, INK, RELATION_COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SIZE = (16.0, 10.0)
# Of the figure: the map lies between two columns of pictures.
_LEFT, _RIGHT, _BOTTOM, _TOP = 0.19, 0.81, 0.11, 0.93
_THUMBNAIL_INCHES = 1.15


def draw_embedding_map(
    places: NDArray[np.floating],
    labels: NDArray[np.integer],
    *,
    thumbnails: Mapping[int, Image] | None = None,
    title: str = 'Map of the embedding',
) -> Image:
    """A dot for each scene; chosen ones are shown at the sides, with a line to their dot.

    Args:
        places: (S, 2), S >= 1; axes have no meaning.
        labels: (S,) values of :class:`Relation`.
        thumbnails: pictures by row of ``places``; about 14 fit.
        title: above the map.

    Returns:
        (1200, 1920, 3) uint8 RGB.

    Raises:
        ConfigError: for arrays that do not fit together.
    """
    places = np.asarray(places, dtype=np.float64)
    if (
        places.ndim != 2
        or places.shape[1:] != (2,)
        or len(places) != len(labels)
        or not len(labels)
    ):
        raise ConfigError(f'a map needs (S, 2) places and S labels, got {places.shape}')
    figure = new_figure(_SIZE, layout=None)
    axes = figure.add_axes((_LEFT, _BOTTOM, _RIGHT - _LEFT, _TOP - _BOTTOM))
    axes.set_title(title, loc='left', fontsize=15, color=INK, fontweight='bold', pad=12)
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_color(FRAME)
    for relation in Relation:
        members = places[labels == relation]
        if len(members):
            axes.scatter(
                members[:, 0],
                members[:, 1],
                s=26,
                color=RELATION_COLOURS[relation],
                edgecolors='white',
                linewidths=0.5,
                label=f'{relation.description} ({len(members)})',
            )
    axes.legend(
        loc='upper center', bbox_to_anchor=(0.5, -0.015), ncols=4, frameon=False, fontsize=11,
        labelcolor=INK, markerscale=1.6,
    )  # fmt: skip
    _show_scenes(axes, places, labels, thumbnails or {})
    return picture_of(figure)


def _show_scenes(
    axes: Axes,
    places: NDArray[np.floating],
    labels: NDArray[np.integer],
    thumbnails: Mapping[int, Image],
) -> None:
    """Half of the pictures at each side, in the order of their dots' heights: few lines cross."""
    across = sorted(thumbnails, key=lambda row: places[row, 0])
    half = (len(across) + 1) // 2
    for rows, column in ((across[:half], _LEFT / 2), (across[half:], (1.0 + _RIGHT) / 2)):
        by_height = sorted(rows, key=lambda row: -places[row, 1])
        heights = _evenly(len(by_height))
        for row, height in zip(by_height, heights, strict=True):
            _show_scene(axes, places[row], int(labels[row]), thumbnails[row], (column, height))


def _evenly(count: int) -> Sequence[float]:
    step = (_TOP - 0.02) / max(count, 1)
    return [_TOP - (idx + 0.5) * step for idx in range(count)]


def _show_scene(
    axes: Axes,
    place: NDArray[np.floating],
    label: int,
    picture: Image,
    position: tuple[float, float],
) -> None:
    from matplotlib.offsetbox import AnnotationBbox, OffsetImage

    colour = RELATION_COLOURS[label]
    zoom = _THUMBNAIL_INCHES * 72.0 / picture.shape[0]
    box = AnnotationBbox(
        OffsetImage(picture, zoom=zoom),
        (float(place[0]), float(place[1])),
        xybox=position,
        xycoords='data',
        boxcoords='figure fraction',
        pad=0.15,
        bboxprops={'edgecolor': colour, 'linewidth': 2.2},
        arrowprops={'arrowstyle': '-', 'color': colour, 'linewidth': 1.0, 'alpha': 0.8},
    )
    axes.add_artist(box)
    axes.plot(*place, 'o', markersize=8, markerfacecolor='none', markeredgecolor=FADED_INK)
