"""In which order objects go to their targets, and by which ways."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from spatial_relations_ros.imitation.contact import Body
from spatial_relations_ros.imitation.feasibility import (
    CONTACT_TOLERANCE,
    MAX_PENETRATION,
    is_supported,
)
from spatial_relations_ros.imitation.manipulation.approach import Approach, find_approach
from spatial_relations_ros.imitation.manipulation.nearness import signed_gap
from spatial_relations_ros.imitation.manipulation.obstacles import Obstacle

_OUT_OF_THE_WAY = np.array([0.0, 0.0, 1e3])

Pair = tuple[Body, Body]


@dataclass(frozen=True)
class Move:
    """One step of carrying out an answer.

    Attributes:
        object_id: of the object that is moved.
        to_target: whether it goes to its target; otherwise it is put aside, out of the way.
    """

    object_id: str
    to_target: bool = True


@dataclass(frozen=True, eq=False)
class MovePlan:
    """How base and relative get to their targets.

    Attributes:
        steps: (index of the object, whether it goes to its target or aside), in order; empty when
            nothing moves or neither object could be placed before the other one.
        approaches: of base and relative; None of an object that does not move.
    """

    steps: tuple[tuple[int, bool], ...]
    approaches: tuple[Approach | None, Approach | None]


@dataclass(frozen=True, eq=False)
class MovePlanner:
    """Orders the moves of one request.

    Args:
        now: base and relative where they stand.
        obstacles: what else stands there.
        table_height: world z of the table, metres.
        approach_length: of the straight way into each target, metres.
    """

    now: Pair
    obstacles: Sequence[Obstacle]
    table_height: float
    approach_length: float

    def plan(self, goal: Pair, moves: tuple[bool, bool]) -> MovePlan:
        """The plan for base and relative at their targets.

        The base goes first, unless the relative stands in its way, is carried by it now, or must
        carry it; then the relative goes first, or one of them is put aside for the while.

        Args:
            goal: base and relative at their targets.
            moves: which of them moves; the other one's target is where it is.
        """
        if moves[0] and moves[1]:
            return self._plan_both(goal)
        if not (moves[0] or moves[1]):
            return MovePlan((), (None, None))
        moved = 0 if moves[0] else 1
        steps = [(moved, True)]
        if self._carriers[moved]:
            steps = [(1 - moved, False), *steps, (1 - moved, True)]
        approach = self._approach(goal[moved], (self.now[1 - moved],))
        approaches = (approach, None) if moved == 0 else (None, approach)
        return MovePlan(tuple(steps), approaches)

    def _plan_both(self, goal: Pair) -> MovePlan:
        first_plan: MovePlan | None = None
        for puts_aside in (False, True):
            for first in (0, 1):
                if not self._can_go_first(goal, first, puts_aside=puts_aside):
                    continue
                plan = self._plan_order(goal, first, puts_aside=puts_aside)
                if all(approach and approach.is_clear for approach in plan.approaches):
                    return plan
                first_plan = first_plan or plan
        if first_plan is not None:
            return first_plan
        plan = self._plan_order(goal, 0, puts_aside=False)
        return MovePlan((), plan.approaches)

    def _can_go_first(self, goal: Pair, first: int, *, puts_aside: bool) -> bool:
        second = 1 - first
        if not puts_aside:
            if self._carriers[first]:
                return False
            if signed_gap(goal[first], self.now[second]) < -MAX_PENETRATION:
                return False
        return not _touches(goal[first], goal[second]) or self._stands_alone(
            goal[first], goal[second]
        )

    def _plan_order(self, goal: Pair, first: int, *, puts_aside: bool) -> MovePlan:
        second = 1 - first
        steps = ((first, True), (second, True))
        approaches = [
            self._approach(goal[first], () if puts_aside else (self.now[second],)),
            self._approach(goal[second], (goal[first],)),
        ]
        return MovePlan(
            ((second, False), *steps) if puts_aside else steps,
            (approaches[first], approaches[second]),
        )

    def _approach(self, target: Body, others: Sequence[Body]) -> Approach:
        return find_approach(target, others, self.obstacles, self.approach_length)

    def carries(self, idx: int) -> bool:
        """Whether the other object would fall if this one were taken away now."""
        return self._carriers[idx]

    @cached_property
    def _carriers(self) -> tuple[bool, bool]:
        """Of each object, whether the other one would fall if it were taken away now."""
        return self._carries(0), self._carries(1)

    def _carries(self, idx: int) -> bool:
        carrier, load = self.now[idx], self.now[1 - idx]
        if not _touches(carrier, load):
            return False
        # Tracked poses leave hairs of air between objects that touch.
        air = max(signed_gap(carrier, load), 0.0)
        resting = load.shifted(np.array([0.0, 0.0, -air]))
        return is_supported(resting, carrier, self.table_height) and not self._stands_alone(
            load, carrier
        )

    def _stands_alone(self, body: Body, other: Body) -> bool:
        """Whether a body stays where it is without the other one."""
        return is_supported(body, other.shifted(_OUT_OF_THE_WAY), self.table_height)


def _touches(first: Body, second: Body) -> bool:
    spacings = [b.shape.field.spacing for b in (first, second) if b.shape.is_estimate]
    return signed_gap(first, second) < CONTACT_TOLERANCE + max(spacings, default=0.0)
