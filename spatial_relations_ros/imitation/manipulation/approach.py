"""A straight way to a target that is free: from above, else from another direction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import Pose
from spatial_relations_ros.imitation.contact import Body
from spatial_relations_ros.imitation.manipulation.nearness import lowest_distance
from spatial_relations_ros.imitation.manipulation.obstacles import Obstacle

_UP = np.array([0.0, 0.0, 1.0])
_HEADINGS = 8
_ELEVATIONS_RAD = (math.radians(45.0), math.radians(5.0))
# A surface that is touched on the way by less is grazed, not hit.
_GRAZING_DEPTH = 0.0007
_MAX_SLACK = 0.005
_BEHIND_HIT = np.array([0.001, 0.002, 0.004, 0.008])
_CHECKED_A_WAY = 32

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Approach:
    """Where a straight way to a target begins.

    Attributes:
        pose: world_from_object there; turned as at the target.
        is_clear: whether nothing stands in the way; else ``pose`` is above the target.
    """

    pose: Pose
    is_clear: bool


def find_approach(
    target: Body, others: Sequence[Body], obstacles: Sequence[Obstacle], length: float
) -> Approach:
    """The first free way of some directions: straight down first, the steeper the earlier.

    Further directions are diagonal and nearly level ones all around, and the axes of the object
    and of the others, such as along the opening of a container that lies.

    Args:
        target: the object where it should go.
        others: bodies that it may touch there but not cross on its way.
        obstacles: what else it must not cross.
        length: of the way, metres.
    """
    sweep = _Sweep(target, others, obstacles, length)
    above = target.shifted(length * _UP).pose
    if sweep.is_free(_UP):
        return Approach(above, True)
    for direction in _other_directions(target, others):
        if sweep.is_free(direction):
            return Approach(target.shifted(length * direction).pose, True)
    return Approach(above, False)


def _other_directions(target: Body, others: Sequence[Body]) -> Array:
    """Unit vectors (D, 3) from the target, none downwards; away from the others first."""
    headings = 2.0 * math.pi * np.arange(_HEADINGS) / _HEADINGS
    around = np.stack([np.cos(headings), np.sin(headings), np.zeros(_HEADINGS)], axis=1)
    tilted = [
        around * math.cos(angle) + np.array([0.0, 0.0, math.sin(angle)])
        for angle in _ELEVATIONS_RAD
    ]
    axes = [sign * body.pose.rotation.T for body in (target, *others) for sign in (1.0, -1.0)]
    directions = np.concatenate([*tilted, *axes])
    directions = directions[directions[:, 2] > -1e-3]
    centre = target.world_points.mean(axis=0)
    away = sum((centre - other.world_points.mean(axis=0) for other in others), np.zeros(3))
    away_share = directions[:, :2] @ away[:2] / max(float(np.linalg.norm(away[:2])), 1e-9)
    return np.asarray(directions[np.lexsort((-away_share, -directions[:, 2].round(2)))])


class _Sweep:
    """Straight ways of one body out of its target, checked by rays from all surface points."""

    def __init__(
        self, target: Body, others: Sequence[Body], obstacles: Sequence[Obstacle], length: float
    ) -> None:
        points = target.world_points
        low, high = points.min(axis=0) - length, points.max(axis=0) + length
        solids = [*others, *(item.body for item in obstacles if item.body is not None)]
        clouds = [item.points_in(low, high) for item in obstacles if item.body is None]
        # The body's points must not enter solids, nor what it passes enter the body.
        self._forward = [_Encounter(solid, points, 1.0, length) for solid in solids]
        passed = [*(solid.world_points for solid in solids), *clouds]
        self._backward = [_Encounter(target, cloud, -1.0, length) for cloud in passed]

    def is_free(self, direction: Array) -> bool:
        """Whether nothing stands in the way along a unit vector (3,)."""
        return not any(part.hits(direction) for part in (*self._forward, *self._backward))


class _Encounter:
    """Points that pass a solid while the object moves."""

    def __init__(self, solid: Body, world_points: Array, sign: float, length: float) -> None:
        self._solid, self._length = solid, length
        solid_from_world = solid.pose.inverse()
        self._origins = solid_from_world.apply(world_points).astype(np.float32)
        self._turn = sign * solid_from_world.rotation

    def hits(self, direction: Array) -> bool:
        """Whether points that move along a direction get deeper into the solid than grazing."""
        if not len(self._origins):
            return False
        local = (self._turn @ direction).astype(np.float32)
        shape = self._solid.shape
        travel = shape.ray_travel(self._origins, np.broadcast_to(local, self._origins.shape))
        hits = np.flatnonzero(travel < self._length)
        if not len(hits):
            return False
        hits = hits[:: max(1, len(hits) // _CHECKED_A_WAY)]
        behind = np.minimum(travel[hits, None] + _BEHIND_HIT, self._length)
        inner = (self._origins[hits, None] + behind[..., None] * local).reshape(-1, 3)
        depth = -float(shape.signed_distance(inner.astype(np.float32)).min())
        return depth > _GRAZING_DEPTH and depth > self._slack

    @cached_property
    def _slack(self) -> float:
        """What depth counts as grazing: bodies that overlap at the target slide out of it."""
        shape = self._solid.shape
        estimate = 0.5 * shape.field.spacing if shape.is_estimate else 0.0
        depth = -lowest_distance(Body(shape, Pose.identity()), self._origins)
        return _GRAZING_DEPTH + estimate + min(max(depth, 0.0), _MAX_SLACK)
