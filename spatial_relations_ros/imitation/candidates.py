"""Starting poses proposed from the shapes: beside, on top, at the edge, in, leaning.

Every proposal rests on the table or on the other object without overlap, as far as moving along
straight lines until contact can tell. Which of them resembles the demonstration is the metric's
business.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import Pose
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.imitation.contact import (
    CONTACT_GAP,
    Body,
    drop,
    overlap,
    travel_to_contact,
)

_DIRECTIONS = 4
_LEAN_ANGLES_RAD = (math.radians(20.0), math.radians(40.0))
_SIDE_GAPS = (0.01, 0.06)
_EDGE_SHARE = 0.8
_CLEARANCE = 0.02
_SILL = 0.012
_HEADING_STEPS = 30
_MAX_OVERLAP = 0.001


@dataclass(frozen=True)
class _Proposer:
    """Places one body around another one that stands still."""

    moving: Body
    fixed: Body
    table_height: float

    def beside(self, rotation: NDArray[np.float64], heading: float, gap: float) -> Body:
        """On the table, ``gap`` metres beside the other body, in a horizontal direction."""
        away = _horizontal(heading)
        start = self._turned(rotation)
        start = self._above_table(self._centred(start, away * self._far_apart(start)))
        travel = travel_to_contact(start, self.fixed, -away, np.zeros((1, 3)))[0]
        if not math.isfinite(travel):
            return start
        return start.shifted(-away * max(travel - gap, 0.0))

    def above(self, rotation: NDArray[np.float64], offset: NDArray[np.float64]) -> Body:
        """Dropped onto (or into) the other body, ``offset`` (2,) metres off its centre."""
        start = self._centred(self._turned(rotation), np.array([*offset, 0.0]))
        top = float(self.fixed.world_points[:, 2].max())
        lift = top - float(start.world_points[:, 2].min()) + _CLEARANCE
        return drop(start.shifted(np.array([0.0, 0.0, lift])), self.fixed, self.table_height)

    def inserted(self, rotation: NDArray[np.float64], heading: float) -> Body:
        """Pushed in from the side as far as the other body's middle, then let down."""
        away = _horizontal(heading)
        start = self._turned(rotation)
        apart = self._far_apart(start)
        start = self._above_table(self._centred(start, away * apart))
        start = start.shifted(np.array([0.0, 0.0, _SILL]))
        travel = float(travel_to_contact(start, self.fixed, -away, np.zeros((1, 3)))[0])
        pushed = start.shifted(-away * min(max(travel - CONTACT_GAP, 0.0), apart))
        return drop(pushed, self.fixed, self.table_height)

    def _turned(self, rotation: NDArray[np.float64]) -> Body:
        pose = Pose.from_rotation(rotation @ self.moving.pose.rotation, np.zeros(3))
        return Body(self.moving.shape, pose)

    def _centred(self, body: Body, offset: NDArray[np.float64]) -> Body:
        return body.shifted(_box_centre(self.fixed) - _box_centre(body) + offset)

    def _above_table(self, body: Body) -> Body:
        lift = self.table_height - float(body.world_points[:, 2].min())
        return body.shifted(np.array([0.0, 0.0, lift]))

    def _far_apart(self, body: Body) -> float:
        sizes = [np.linalg.norm(np.ptp(b.world_points, axis=0)) for b in (body, self.fixed)]
        return 0.5 * float(sizes[0] + sizes[1]) + _CLEARANCE


def propose_poses(moving: Body, fixed: Body, table_height: float) -> Iterator[Pose]:
    """Poses (world_from_object) of the moving body that rest somewhere around the fixed one.

    Args:
        moving: the object to place; its present orientation counts as upright.
        fixed: the object that stays.
        table_height: world height of the table, metres.

    Yields:
        About 100 poses, one by one as they are found; those that overlap the fixed body are
        left out.
    """
    for body in _propose(_Proposer(moving, fixed, table_height)):
        if overlap(body, fixed)[0] < _MAX_OVERLAP:
            yield body.pose


def _propose(proposer: _Proposer) -> Iterator[Body]:
    main = _main_heading(proposer.fixed)
    headings = [main + 2.0 * math.pi * k / _DIRECTIONS for k in range(_DIRECTIONS)]
    aligned = _yaw(main - _main_heading(proposer.moving))
    lying = [_tilt(heading, math.pi / 2.0) @ aligned for heading in headings[:2]]
    half_size = 0.5 * np.ptp(proposer.fixed.world_points[:, :2], axis=0)
    for rotation in (np.eye(3), aligned, _yaw(math.pi / 2.0) @ aligned, *lying):
        yield proposer.above(rotation, np.zeros(2))
        for heading in headings:
            yield proposer.above(rotation, _EDGE_SHARE * half_size * _horizontal(heading)[:2])
            yield proposer.inserted(rotation, heading)
            for gap in _SIDE_GAPS:
                yield proposer.beside(rotation, heading, gap)
    for heading in headings:
        for angle in _LEAN_ANGLES_RAD:
            # Its top tips towards the other body, or, dropped from above, towards a wall.
            lean = _tilt(heading + math.pi, angle) @ aligned
            yield proposer.beside(lean, heading, CONTACT_GAP)
            inward = -0.3 * half_size * _horizontal(heading)[:2]
            yield proposer.above(_tilt(heading, angle) @ aligned, inward)


def _horizontal(heading: float) -> NDArray[np.float64]:
    return np.array([math.cos(heading), math.sin(heading), 0.0])


def _yaw(angle_rad: float) -> NDArray[np.float64]:
    return matrix_from_rotvec(np.array([0.0, 0.0, angle_rad]))


def _tilt(heading: float, angle_rad: float) -> NDArray[np.float64]:
    """Rotation that tips the top of an object towards a horizontal heading."""
    axis = np.cross([0.0, 0.0, 1.0], _horizontal(heading))
    return matrix_from_rotvec(angle_rad * axis)


def _main_heading(body: Body) -> float:
    """Horizontal angle, 0 to pi/2, of the tightest upright box around a body."""
    points = body.world_points[:, :2]
    angles = np.linspace(0.0, math.pi / 2.0, _HEADING_STEPS, endpoint=False)
    along = np.stack([np.cos(angles), np.sin(angles)])
    across = np.stack([-np.sin(angles), np.cos(angles)])
    areas = np.ptp(points @ along, axis=0) * np.ptp(points @ across, axis=0)
    return float(angles[int(areas.argmin())])


def _box_centre(body: Body) -> NDArray[np.float64]:
    points = body.world_points
    return np.asarray(0.5 * (points.min(axis=0) + points.max(axis=0)))
