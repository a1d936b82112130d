"""Which placements the arms reach, and turning others to where they do."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from spatial_relations_ros.core import Pose, Scene
from spatial_relations_ros.imitation.candidates import PosePair
from spatial_relations_ros.imitation.options import ImitationOptions
from spatial_relations_ros.imitation.proposals import Proposal
from spatial_relations_ros.imitation.shape import Shape
from spatial_relations_ros.placement.resting import about_z
from spatial_relations_ros.placement.settling import settle

_UP = np.array([0.0, 0.0, 1.0])
# Nearest first: a relation does not depend on the heading, the base's shape may.
_TURNS_RAD = tuple(math.radians(sign * angle) for angle in range(20, 181, 20) for sign in (1, -1))


@dataclass(frozen=True, eq=False)
class Reaching:
    """Reach in one request.

    Args:
        test: the objects where they stand.
        shapes: of base and relative.
        movable: which of them may move.
        options: of the request.
    """

    test: Scene
    shapes: tuple[Shape, Shape]
    movable: tuple[bool, bool]
    options: ImitationOptions

    def problems(self, idx: int, target: Pose, approach: Pose) -> tuple[str, ...]:
        """Why no arm takes an object from where it is to its target; empty when one does.

        An arm must reach the gripper where the grasp is known, else the middle of the object.

        Args:
            idx: 0 of the base, 1 of the relative.
            target: world_from_object where it should go.
            approach: world_from_object where the straight way there begins.
        """
        if self.options.arm is None:
            return ()
        item, points = self.test.objects[idx], self.shapes[idx].points
        grasp = self.options.grasps.get(item.object_id)
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        held = middle if grasp is None else grasp.translation
        places = {
            'is now': item.world_from_object.apply(held),
            'would be': target.apply(held),
            'would be approached': approach.apply(held),
        }
        return self.options.arm.problems(item.object_id, places)

    def reaches(self, targets: PosePair) -> bool:
        """Whether arms take all that may move to its target, coming from above."""
        above = self.options.approach_height * _UP
        return not any(
            self.problems(idx, target, Pose(target.translation + above, target.quat_wxyz))
            for idx, target in enumerate(targets)
            if self.movable[idx]
        )

    def turned(self, proposal: Proposal, poses: Callable[[Proposal], PosePair | None]) -> Proposal:
        """A proposal at another heading about the base that is in reach; itself without one.

        Args:
            proposal: to turn, when it is out of reach.
            poses: targets in the world of a proposal; None for one that cannot be.
        """
        if self.options.arm is None or self.options.keep_heading or not self.movable[1]:
            return proposal
        if (targets := poses(proposal)) is None or self.reaches(targets):
            return proposal
        for angle in _TURNS_RAD:
            moved = proposal.relative.turned(about_z(angle))
            turned = Proposal(proposal.base, moved, proposal.manner, proposal.cell)
            if (targets := poses(turned)) is None or not self.reaches(targets):
                continue
            settled = settle(proposal.manner, moved, proposal.base)
            if settled is not None:
                turned = Proposal(proposal.base, settled, proposal.manner, proposal.cell)
                if (targets := poses(turned)) is not None and self.reaches(targets):
                    return turned
        return proposal
