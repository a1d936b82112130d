"""How far a relation has changed since it was looked at last."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spatial_relations_ros.core import Pose, Scene
from spatial_relations_ros.core.rotations import tilt_angle_rad


@dataclass(frozen=True)
class RelationChange:
    """What moved.

    Attributes:
        metres: how far the relative object moved as seen from the base.
        angle_rad: how far it turned as seen from the base, or the base was tilted, whichever is
            more. Turning both about the vertical changes no relation.
    """

    metres: float
    angle_rad: float

    def exceeds(self, metres: float, angle_rad: float) -> bool:
        """Whether either is more than a limit."""
        return self.metres > metres or self.angle_rad > angle_rad


def relation_change(before: Scene, after: Scene) -> RelationChange:
    """The change from one scene of two objects to a later one of the same objects."""
    was, now = (
        scene.base.world_from_object.inverse() @ scene.relative.world_from_object
        for scene in (before, after)
    )
    base_turn = after.base.world_from_object.rotation @ before.base.world_from_object.rotation.T
    return RelationChange(
        metres=float(np.linalg.norm(now.translation - was.translation)),
        angle_rad=max(turn_angle_rad(was, now), tilt_angle_rad(base_turn)),
    )


def turn_angle_rad(first: Pose, second: Pose) -> float:
    """Angle between the orientations of two poses, 0 to pi."""
    quat_wxyz = (first.inverse() @ second).quat_wxyz
    return float(2.0 * np.arctan2(np.linalg.norm(quat_wxyz[1:]), abs(quat_wxyz[0])))
