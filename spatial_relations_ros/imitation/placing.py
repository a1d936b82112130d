"""What targets mean for the real world: checks, ways in, gripper poses and order of moves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from spatial_relations_ros.core import Pose, Scene
from spatial_relations_ros.imitation import statics
from spatial_relations_ros.imitation.contact import Body
from spatial_relations_ros.imitation.feasibility import (
    PlacementCheck,
    check_placement,
    overlap_depth,
)
from spatial_relations_ros.imitation.manipulation import Move, check_obstacles
from spatial_relations_ros.imitation.manipulation.approach import Approach
from spatial_relations_ros.imitation.manipulation.moves import MovePlanner
from spatial_relations_ros.imitation.options import ImitationOptions
from spatial_relations_ros.imitation.reaching import Reaching
from spatial_relations_ros.imitation.result import ObjectPlacement
from spatial_relations_ros.imitation.shape import Shape

_UNMOVED_METRES = 1e-4
_UNMOVED_RAD = 1e-3


@dataclass(frozen=True)
class Placed:
    """Base and relative at their targets.

    Attributes:
        placements: of base and relative.
        violations: what is physically wrong, in words.
        order: of the moves.
    """

    placements: tuple[ObjectPlacement, ObjectPlacement]
    violations: tuple[str, ...]
    order: tuple[Move, ...]


@dataclass(frozen=True, eq=False)
class Placing:
    """Checks the targets of one request.

    Args:
        test: the objects where they stand.
        shapes: of base and relative.
        movable: which of them may move.
        table_height: world z of the table, metres.
        options: of the request.
    """

    test: Scene
    shapes: tuple[Shape, Shape]
    movable: tuple[bool, bool]
    table_height: float
    options: ImitationOptions

    def at(self, targets: tuple[Pose, Pose]) -> Placed:
        """Both objects at world_from_object of base and relative."""
        goal = Body(self.shapes[0], targets[0]), Body(self.shapes[1], targets[1])
        moves = self._moves(0, targets[0]), self._moves(1, targets[1])
        plan = self._planner.plan(goal, moves)
        placements, violations = [], []
        ids = self.test.object_ids
        depth = overlap_depth(*goal)
        for k, approach in enumerate(plan.approaches):
            check = self._check(k, goal, depth)
            placement, problems = self._placement(k, goal[k], approach, check)
            placements.append(placement)
            if self.movable[k]:
                violations += [*check.violations, *problems]
            elif moves[1 - k] and self._planner.carries(1 - k) and not check.supported:
                violations.append(
                    f'{ids[k]} stands on {ids[1 - k]} and would fall when that is moved'
                )
        if all(self.movable) and moves[0] and not violations:
            violations += self._tipping(goal)
        order = tuple(Move(ids[idx], to_target) for idx, to_target in plan.steps)
        return Placed((placements[0], placements[1]), tuple(violations), order)

    def _tipping(self, goal: tuple[Body, Body]) -> list[str]:
        """What is wrong where a base that is placed anew does not bear the relative."""
        if any(body.shape.is_estimate for body in goal):
            return []
        if statics.stay_together(*goal, self.table_height):
            return []
        base, relative = self.test.object_ids
        return [f'{base} would not stay under {relative}']

    @cached_property
    def _reaching(self) -> Reaching:
        return Reaching(self.test, self.shapes, self.movable, self.options)

    @cached_property
    def _planner(self) -> MovePlanner:
        base, relative = (
            Body(shape, item.world_from_object)
            for shape, item in zip(self.shapes, self.test.objects, strict=True)
        )
        options = self.options
        return MovePlanner(
            (base, relative), options.obstacles, self.table_height, options.approach_height
        )

    def _moves(self, idx: int, target: Pose) -> bool:
        current = self.test.objects[idx].world_from_object
        return self.movable[idx] and not target.is_close(
            current, metres=_UNMOVED_METRES, angle_rad=_UNMOVED_RAD
        )

    def _check(self, idx: int, goal: tuple[Body, Body], depth: float) -> PlacementCheck:
        """Overlap with the other object and the table, support, and overlap with obstacles."""
        name, other_name = self.test.object_ids[idx], self.test.object_ids[1 - idx]
        check = check_placement(
            name, goal[idx], other_name, goal[1 - idx], self.table_height, depth=depth
        )
        if not self.options.obstacles or not self.movable[idx]:
            return check
        beside = check_obstacles(name, goal[idx], self.options.obstacles)
        return PlacementCheck(
            max(check.penetration, beside.penetration),
            check.supported,
            (*check.violations, *beside.violations),
        )

    def _placement(
        self, idx: int, target: Body, approach: Approach | None, check: PlacementCheck
    ) -> tuple[ObjectPlacement, Sequence[str]]:
        """The placement of one object, and what is wrong with the way to it."""
        item, length = self.test.objects[idx], self.options.approach_height
        name = item.object_id
        above = target.shifted(np.array([0.0, 0.0, length])).pose
        approach_pose = above if approach is None else approach.pose
        is_clear = approach is None or approach.is_clear
        problems = []
        if not is_clear:
            problems.append(
                f'{name} could not be brought there: no straight way of {length:.2f} m is free'
            )
        unreached = self._reaching.problems(idx, target.pose, approach_pose)
        if approach is not None:
            problems += unreached
        grasp = self.options.grasps.get(name)
        placement = ObjectPlacement(
            object_id=name,
            current=item.world_from_object,
            target=target.pose,
            approach=approach_pose,
            reachable=not unreached,
            penetration=check.penetration,
            supported=check.supported,
            approach_clear=is_clear,
            gripper_target=None if grasp is None else target.pose @ grasp,
            gripper_approach=None if grasp is None else approach_pose @ grasp,
        )
        return placement, problems
