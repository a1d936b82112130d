"""Where the objects of a proposal come to be in the world."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from spatial_relations_ros.core import Scene
from spatial_relations_ros.core.rotations import tilt_angle_rad
from spatial_relations_ros.imitation.candidates import PosePair
from spatial_relations_ros.imitation.proposals import Proposal
from spatial_relations_ros.imitation.tabletop import Tabletop
from spatial_relations_ros.placement.body import Placed
from spatial_relations_ros.placement.resting import about_z

_SAME_HEIGHT = 0.004
_SAME_TILT_RAD = 0.05


@dataclass(frozen=True, eq=False)
class Targets:
    """From proposals to poses of the objects; what may not move stays where it is.

    Attributes:
        test: the objects where they stand.
        tabletop: the same objects as solids.
        movable: whether base and relative may move.
    """

    test: Scene
    tabletop: Tabletop
    movable: tuple[bool, bool]

    @cached_property
    def now(self) -> tuple[Placed, Placed]:
        """Base and relative where they stand."""
        base, relative = (
            self.tabletop.placed(role, item.world_from_object)
            for role, item in enumerate(self.test.objects)
        )
        return base, relative

    def poses(self, proposal: Proposal) -> PosePair | None:
        """World poses; None when a relative that must not move would have to."""
        base, relative = proposal.base, proposal.relative
        if not self.movable[1]:
            now = self.now[1]
            turn = now.rotation @ relative.rotation.T
            height = float(now.translation[2] - relative.translation[2])
            if tilt_angle_rad(turn) > _SAME_TILT_RAD or abs(height) > _SAME_HEIGHT:
                return None
            yaw = about_z(float(np.arctan2(turn[1, 0], turn[0, 0])))
            shift = now.translation - yaw @ relative.translation
            moved = Placed(base.body, yaw @ base.rotation, yaw @ base.translation + shift)
            return self.tabletop.pose(0, moved.on_table()), self.test.relative.world_from_object
        base_pose = self.test.base.world_from_object
        if self.movable[0]:
            base_pose = self.tabletop.pose(0, base)
        return base_pose, self.tabletop.pose(1, relative)
