"""Bringing a body that is nearly at rest to rest, in the manner in which it was placed."""

from __future__ import annotations

import enum

import numpy as np

from spatial_relations_ros.placement.body import FloatArray, Placed
from spatial_relations_ros.placement.contact import is_clear, travel_to_contact
from spatial_relations_ros.placement.leaning_on import settle_in_rim
from spatial_relations_ros.placement.rest_poses import rotation_between
from spatial_relations_ros.placement.resting import (
    DOWN,
    UP,
    above,
    dropped,
    pushed,
)

MAX_SNAP_RAD = float(np.deg2rad(12.0))
_LEAST_MARGIN = 0.001
_LEVEL_SINE = 0.03
_CLEAR = 2e-4
_LIFT = 0.012


class Manner(enum.Enum):
    """How a body comes to rest around another."""

    BESIDE = 'stands on the table, clear of the other'
    DROPPED = 'let down from above onto the other or into it'
    LOWERED = 'let down from where it is, under a roof'
    LEANING = 'stands on the table and is pushed against the other'
    IN_RIM = 'stands in the other and slides until it leans on its rim or wall'


def settle(manner: Manner, moving: Placed, fixed: Placed) -> Placed | None:
    """The body at rest, as near to its pose as moves along straight lines allow.

    Args:
        manner: how it rests.
        moving: nearly at rest; what is nearly level is made level.
        fixed: the other body, on the table z = 0.

    Returns:
        None when it cannot come to rest in this manner.
    """
    if manner is Manner.BESIDE:
        return _beside(snapped(moving), fixed)
    if manner is Manner.DROPPED:
        level = snapped(moving)
        middle = 0.5 * (level.world_vertices.min(axis=0) + level.world_vertices.max(axis=0))
        return dropped(above(level, fixed, middle), fixed)
    if manner is Manner.LOWERED:
        return _lowered(moving, fixed)
    direction = lean_direction(moving, fixed)
    if manner is Manner.LEANING:
        standing = moving.on_table()
        start = standing.moved(-direction * (fixed.body.radius + moving.body.radius + 0.05))
        return pushed(start, fixed, direction)
    landed = settle_in_rim(fixed, moving, direction)
    return None if isinstance(landed, str) else landed


def snapped(placed: Placed, max_angle_rad: float = MAX_SNAP_RAD) -> Placed:
    """Turns a body level when it is within some degrees of an orientation in which it rests."""
    poses = [pose for pose in placed.body.model.rest_poses if pose.margin > _LEAST_MARGIN]
    if not poses:
        return placed
    ups = np.array([pose.rotation[2] for pose in poses]) @ placed.rotation.T
    nearest = int(ups[:, 2].argmax())
    if np.arccos(np.clip(ups[nearest, 2], -1.0, 1.0)) > max_angle_rad:
        return placed
    level = rotation_between(ups[nearest], UP)
    return Placed(placed.body, level @ placed.rotation, placed.translation)


def lean_direction(moving: Placed, fixed: Placed) -> FloatArray:
    """Horizontal unit vector (3,) from the foot of a tilted body towards where it would fall.

    A body that is level falls towards the middle of the other one.
    """
    poses = [pose for pose in moving.body.model.rest_poses if pose.margin > _LEAST_MARGIN]
    tip = np.zeros(3)
    if poses:
        ups = np.array([pose.rotation[2] for pose in poses]) @ moving.rotation.T
        tip = ups[int(ups[:, 2].argmax())] * [1.0, 1.0, 0.0]
    if np.linalg.norm(tip) < _LEVEL_SINE:
        tip = (fixed.translation - moving.translation) * [1.0, 1.0, 0.0]
    else:
        foot = moving.world_vertices[moving.world_vertices[:, 2].argmin()]
        # What is lifted on one side falls back, though its top points away.
        tip = tip * np.copysign(1.0, (moving.centre_of_mass() - foot) @ tip)
    length = float(np.linalg.norm(tip))
    return tip / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])


def _beside(moving: Placed, fixed: Placed) -> Placed | None:
    standing = moving.on_table()
    if is_clear(standing, fixed, _CLEAR):
        return standing
    away = (standing.translation - fixed.translation) * [1.0, 1.0, 0.0]
    length = float(np.linalg.norm(away))
    away = away / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    start = standing.moved(away * (fixed.body.radius + moving.body.radius + 0.05))
    touching = pushed(start, fixed, -away)
    return None if touching is None else touching.moved(2.0 * _CLEAR * away)


def _lowered(moving: Placed, fixed: Placed) -> Placed | None:
    raised = moving
    for lift in (0.0, 0.25 * _LIFT, _LIFT):
        raised = moving.moved(UP * lift)
        if raised.world_vertices[:, 2].min() >= 0.0 and is_clear(raised, fixed, _CLEAR):
            travel = travel_to_contact(raised, fixed, DOWN)
            return raised.moved(DOWN * min(travel, float(raised.world_vertices[:, 2].min())))
    return None
