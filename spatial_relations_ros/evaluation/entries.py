"""Results as plain JSON content, the same from every command."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from spatial_relations_ros.core import Pose
    from spatial_relations_ros.imitation import ImitationAnswer

ROLES = ('base', 'relative')


def pose_entry(pose: Pose) -> dict[str, list[float]]:
    """A pose: metres and a quaternion with the scalar first, rounded to a nanometre."""
    return {
        't': [round(float(value), 9) for value in pose.translation],
        'q_wxyz': [round(float(value), 9) for value in pose.quat_wxyz],
    }


def answer_entry(answer: ImitationAnswer) -> dict[str, Any]:
    """One answer of an imitation."""
    return {
        'poses': {
            role: pose_entry(placement.target)
            for role, placement in zip(ROLES, answer.placements, strict=True)
        },
        'distance': float(answer.distance),
        'feasible': bool(answer.feasible),
        'violations': list(answer.violations),
    }
