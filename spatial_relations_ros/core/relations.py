"""The seven relations of the Freiburg Spatial Relations dataset."""

from __future__ import annotations

import enum


class Relation(enum.IntEnum):
    """Relation of the relative object to the base; the values are the dataset's labels."""

    ON_TOP = 0
    INSIDE = 1
    NEXT_TO = 2
    INCLINED = 3
    ON_TOP_EDGE = 4
    INSIDE_LYING = 5
    INSIDE_INCLINED = 6

    @property
    def description(self) -> str:
        """The relation in words."""
        return _DESCRIPTIONS[self]


_DESCRIPTIONS = {
    Relation.ON_TOP: 'on top',
    Relation.INSIDE: 'inside, upright',
    Relation.NEXT_TO: 'next to',
    Relation.INCLINED: 'inclined, leaning',
    Relation.ON_TOP_EDGE: 'on top, at a corner or edge',
    Relation.INSIDE_LYING: 'inside a container that lies on its side',
    Relation.INSIDE_INCLINED: 'inside and inclined',
}
