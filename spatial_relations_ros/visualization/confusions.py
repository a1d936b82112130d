"""Confusion matrices of the seven relations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError, Relation
from spatial_relations_ros.visualization.diagrams import new_figure, picture_of
from spatial_relations_ros.visualization.images import Image
from spatial_relations_ros.visualization.palette import FADED_INK, INK


def draw_confusion(confusion: NDArray[np.integer], *, title: str = 'Confusion') -> Image:
    """A matrix with counts, each row shaded by its shares.

    Args:
        confusion: (7, 7) counts; rows are true relations, columns those found.
        title: above it.

    Returns:
        (960, 1140, 3) uint8 RGB.

    Raises:
        ConfigError: for another shape.
    """
    num = len(Relation)
    if confusion.shape != (num, num):
        raise ConfigError(f'a confusion of {num} relations is needed, got {confusion.shape}')
    shares = confusion / np.maximum(confusion.sum(axis=1, keepdims=True), 1)
    names = [relation.name.replace('_', ' ').lower() for relation in Relation]
    figure = new_figure((9.5, 8.0))
    axes = figure.add_subplot()
    axes.imshow(shares, cmap='Blues', vmin=0.0, vmax=1.0)
    axes.set_title(title, loc='left', fontsize=13, color=INK, fontweight='bold', pad=12)
    axes.set_xticks(range(num), names, rotation=35, ha='right', color=INK)
    axes.set_yticks(range(num), names, color=INK)
    axes.set_xlabel('majority of the five nearest scenes', color=FADED_INK)
    axes.set_ylabel('relation of the test scene', color=FADED_INK)
    axes.tick_params(length=0)
    for side in axes.spines.values():
        side.set_visible(False)
    for row, column in np.ndindex(num, num):
        if confusion[row, column]:
            axes.text(
                column,
                row,
                f'{confusion[row, column]}\n{100.0 * shares[row, column]:.1f} %',
                ha='center',
                va='center',
                fontsize=9,
                color='white' if shares[row, column] > 0.55 else INK,
            )
    return picture_of(figure)
