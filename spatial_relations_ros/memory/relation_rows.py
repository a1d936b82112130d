"""What is known of relations without their clouds, as rows."""

from __future__ import annotations

import sqlite3
from dataclasses import dataclass
from typing import Any

from spatial_relations_ros.memory.damage import damaged_text, is_storable_text


@dataclass(frozen=True)
class RememberedRelation:
    """What is known of a remembered relation without reading its clouds.

    Attributes:
        name: unique.
        base_id: object id of the base.
        relative_id: object id of the relative.
        stamp_ns: time of the scene, nanoseconds.
        frame_id: the scene's world frame.
        model_hash: of the model that embedded it.
    """

    name: str
    base_id: str
    relative_id: str
    stamp_ns: int
    frame_id: str
    model_hash: str


def read_relations(
    connection: sqlite3.Connection,
) -> tuple[tuple[RememberedRelation, ...], dict[int, str]]:
    """All relations that can be read, by name; by id what is wrong with the others."""
    rows = connection.execute(
        'SELECT relation.relation_id, name, base.object_id, relative.object_id, stamp_ns, '
        'frame_id, model_hash FROM relations AS relation '
        'LEFT JOIN objects AS base '
        'ON base.relation_id = relation.relation_id AND base.role = 0 '
        'LEFT JOIN objects AS relative '
        'ON relative.relation_id = relation.relation_id AND relative.role = 1 '
        'ORDER BY name'
    ).fetchall()
    damaged = {
        row[0]: damaged_text(row[0], row[1], problem) for row in rows if (problem := _problem(row))
    }
    found = tuple(RememberedRelation(*row[1:]) for row in rows if row[0] not in damaged)
    return found, damaged


def _problem(row: tuple[Any, ...]) -> str:
    """What is wrong with a row; empty when nothing is."""
    _, name, base_id, relative_id, stamp_ns, frame_id, model_hash = row
    if base_id is None or relative_id is None:
        return 'it has less than two objects'
    # SQLite keeps what it is given, whatever the column is for.
    if not isinstance(stamp_ns, int):
        return f'its time {stamp_ns!r} is no whole number'
    for text in (name, base_id, relative_id, frame_id, model_hash):
        if not isinstance(text, str) or not is_storable_text(text):
            return 'one of its texts is no valid UTF-8'
    return ''
