"""Results as plain JSON content, the same from every command."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from spatial_relations_ros.core import Pose
    from spatial_relations_ros.imitation import ImitationAnswer, ObjectPlacement

ROLES = ('base', 'relative')


def pose_entry(pose: Pose) -> dict[str, list[float]]:
    """A pose: metres and a quaternion with the scalar first, rounded to a nanometre."""
    return {
        't': [round(float(value), 9) for value in pose.translation],
        'q_wxyz': [round(float(value), 9) for value in pose.quat_wxyz],
    }


def answer_entry(answer: ImitationAnswer) -> dict[str, Any]:
    """One answer of an imitation."""
    placements = dict(zip(ROLES, answer.placements, strict=True))
    roles = {placement.object_id: role for role, placement in placements.items()}
    return {
        'poses': {role: pose_entry(placement.target) for role, placement in placements.items()},
        'distance': float(answer.distance),
        'feasible': bool(answer.feasible),
        'violations': list(answer.violations),
        'order': [
            {'role': roles[move.object_id], 'to': 'target' if move.to_target else 'aside'}
            for move in answer.order
        ],
        'targets': {role: _target_entry(placement) for role, placement in placements.items()},
    }


def _target_entry(placement: ObjectPlacement) -> dict[str, Any]:
    """What a manipulator needs beside the pose."""
    gripper = placement.gripper_target, placement.gripper_approach
    return {
        'approach': pose_entry(placement.approach),
        'approach_clear': bool(placement.approach_clear),
        'reachable': bool(placement.reachable),
        'gripper': None if gripper[0] is None else pose_entry(gripper[0]),
        'gripper_approach': None if gripper[1] is None else pose_entry(gripper[1]),
    }
