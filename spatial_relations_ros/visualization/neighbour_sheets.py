"""Test scenes beside the scenes that a metric finds most alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from spatial_relations_ros.core import ConfigError, Relation
from spatial_relations_ros.visualization.images import Image
from spatial_relations_ros.visualization.palette import INK, RIGHT, WRONG, Rgb, as_bytes
from spatial_relations_ros.visualization.sheets import contact_sheet

_BORDER = 5


@dataclass(frozen=True, eq=False)
class ShownScene:
    """A scene on a sheet.

    Attributes:
        picture: (H, W, 3) uint8 RGB.
        relation: its label.
        distance: to the test scene; None for the test scene itself.
    """

    picture: Image
    relation: Relation
    distance: float | None = None


def draw_neighbour_sheet(rows: Sequence[Sequence[ShownScene]]) -> Image:
    """A row a test scene: itself first, framed dark, then its neighbours, nearest first.

    Neighbours of the same relation are framed green, others red.

    Args:
        rows: at least one, all equally long.

    Returns:
        (H, W, 3) uint8 RGB.

    Raises:
        ConfigError: without rows or with rows of several lengths.
    """
    if not rows or len({len(row) for row in rows}) != 1 or not rows[0]:
        raise ConfigError(
            f'a sheet needs rows of one length, got lengths {[len(row) for row in rows]}'
        )
    pictures, captions = [], []
    for row in rows:
        for shown in row:
            is_query = shown is row[0]
            is_right = shown.relation == row[0].relation
            colour = INK if is_query else RIGHT if is_right else WRONG
            pictures.append(_framed(shown.picture, colour))
            name = shown.relation.name.replace('_', ' ').lower()
            near = '' if shown.distance is None else f'{shown.distance:.2f}  '
            captions.append(f'test: {name}' if is_query else f'{near}{name}')
    return contact_sheet(pictures, captions, columns=len(rows[0]))


def _framed(picture: Image, colour: Rgb) -> Image:
    framed = np.empty(
        (picture.shape[0] + 2 * _BORDER, picture.shape[1] + 2 * _BORDER, 3), dtype=np.uint8
    )
    framed[:] = as_bytes(colour)
    framed[_BORDER:-_BORDER, _BORDER:-_BORDER] = picture
    return framed
