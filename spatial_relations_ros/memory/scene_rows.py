"""Scenes as rows: exact round trips of poses (float64) and clouds (float32)."""

from __future__ import annotations

import math
import sqlite3
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import (
    CloudSource,
    InvalidSceneError,
    MemoryFileError,
    Pose,
    Scene,
    SceneObject,
    SpatialRelationsError,
    TriangleMesh,
)
from spatial_relations_ros.memory.damage import damaged_text, is_storable_text, read_text

ROLES = ('base', 'relative')
# SQLite keeps whole numbers in eight bytes.
INTEGERS = range(-(2**63), 2**63)


def check_storable(scene: Scene) -> None:
    """Looks whether a scene can be stored.

    Raises:
        InvalidSceneError: when a text is no UTF-8 or the time has more than 64 bits.
    """
    for text in (*scene.object_ids, scene.frame_id):
        if not is_storable_text(text):
            raise InvalidSceneError(f'{text!r} is no valid UTF-8; give ids and frames that are')
    if scene.stamp_ns not in INTEGERS:
        raise InvalidSceneError(
            f'a scene of the time {scene.stamp_ns} ns cannot be stored; give one from '
            f'{INTEGERS[0]} to {INTEGERS[-1]}'
        )


def insert_objects(connection: sqlite3.Connection, relation_id: int, scene: Scene) -> None:
    """Stores both objects of a scene under a relation's id."""
    for role, item in enumerate(scene.objects):
        pose = np.concatenate(
            [item.world_from_object.translation, item.world_from_object.quat_wxyz]
        )
        connection.execute(
            'INSERT INTO objects VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)',
            (
                relation_id,
                role,
                item.object_id,
                _blob(pose, '<f8'),
                _blob(item.points, '<f4'),
                int(item.source),
                None if math.isnan(item.support) else float(item.support),
                None if item.mesh is None else _blob(item.mesh.vertices, '<f4'),
                None if item.mesh is None else _blob(item.mesh.triangles, '<i4'),
            ),
        )


def read_scene(connection: sqlite3.Connection, relation_id: int) -> Scene | None:
    """The scene that :func:`insert_objects` stored; None when there is no such relation.

    Raises:
        MemoryFileError: when a row is missing or damaged; it names the relation.
    """
    # Texts as bytes: SQLite's own error for one that is no UTF-8 tells neither row nor relation.
    relation = connection.execute(
        'SELECT CAST(name AS BLOB), CAST(frame_id AS BLOB), stamp_ns '
        'FROM relations WHERE relation_id = ?',
        (relation_id,),
    ).fetchone()
    if relation is None:
        return None
    rows = connection.execute(
        'SELECT CAST(object_id AS BLOB), pose, points, source, support, vertices, triangles '
        'FROM objects WHERE relation_id = ? ORDER BY role',
        (relation_id,),
    ).fetchall()
    name, frame_id, stamp_ns = relation
    try:
        return _scene(rows, int(stamp_ns), frame_id.decode())
    except (SpatialRelationsError, OverflowError, TypeError, ValueError) as error:
        raise MemoryFileError(damaged_text(relation_id, read_text(name), str(error))) from error


def _scene(rows: Sequence[tuple[Any, ...]], stamp_ns: int, frame_id: str) -> Scene:
    if len(rows) != len(ROLES):
        raise MemoryFileError(f'it has {len(rows)} objects instead of two')
    base, relative = (_object(row) for row in rows)
    return Scene(base, relative, stamp_ns=stamp_ns, frame_id=frame_id)


def _object(row: tuple[Any, ...]) -> SceneObject:
    object_id, pose, points, source, support, vertices, triangles = row
    numbers = _read_blob(pose, '<f8')
    mesh = None
    if vertices is not None:
        mesh = TriangleMesh(
            _read_blob(vertices, '<f4').reshape(-1, 3), _read_blob(triangles, '<i4').reshape(-1, 3)
        )
    return SceneObject(
        object_id.decode(),
        _read_blob(points, '<f4').reshape(-1, 3),
        Pose(numbers[:3], numbers[3:]),
        source=CloudSource(source),
        support=math.nan if support is None else float(support),
        mesh=mesh,
    )


def _blob(values: NDArray[Any], dtype: str) -> bytes:
    return np.ascontiguousarray(values, dtype=dtype).tobytes()


def _read_blob(data: bytes, dtype: str) -> NDArray[Any]:
    """The array (N,) of a blob.

    Raises:
        MemoryFileError: when the blob holds no whole number of values.
    """
    try:
        return np.frombuffer(data, dtype=dtype)
    except (TypeError, ValueError) as error:
        raise MemoryFileError(f'a stored array is damaged: {error}') from error
