"""Imitations as the page shows them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from spatial_relations_msgs.msg import Imitation, PoseTarget

from spatial_relations_ros.perception.messages import read_pose
from spatial_relations_ros.visualization.report import pose_content


def number(value: float) -> float | None:
    """The number; null in JSON when it is none."""
    return round(float(value), 6) if math.isfinite(value) else None


def progress_content(feedback: Any) -> dict[str, Any]:
    """The feedback of an ImitateRelation action."""
    return {
        'step': int(feedback.step),
        'distance': number(feedback.distance),
        'feasible': bool(feedback.feasible),
        'poses': _poses(feedback.best.targets),
    }


def result_content(
    result: Any, *, reference: dict[str, Any], test: dict[str, Any]
) -> dict[str, Any]:
    """The result of an ImitateRelation action with the scenes that it was about."""
    return {
        'success': bool(result.success),
        'message': str(result.message),
        'initial_distance': number(result.initial_distance),
        'duration': number(result.duration),
        'history': [number(value) for value in result.distance_history],
        'answers': [_answer(answer) for answer in result.answers],
        'reference': reference,
        'test': test,
    }


def _answer(answer: Imitation) -> dict[str, Any]:
    return {
        'distance': number(answer.distance),
        'confidence': number(answer.confidence),
        'feasible': bool(answer.feasible),
        'violations': [str(violation) for violation in answer.violations],
        'poses': _poses(answer.targets),
        'targets': [_target(target) for target in answer.targets],
    }


def _target(target: PoseTarget) -> dict[str, Any]:
    return {
        'id': str(target.object_id),
        'moves': not read_pose(target.current.pose).is_close(
            read_pose(target.target.pose), metres=1e-4, angle_rad=1e-3
        ),
        'approach': pose_content(read_pose(target.approach.pose)),
        'reachable': bool(target.reachable),
        'penetration': number(target.penetration),
        'supported': bool(target.supported),
    }


def _poses(targets: Sequence[PoseTarget]) -> list[list[float]]:
    return [pose_content(read_pose(target.target.pose)) for target in targets]
