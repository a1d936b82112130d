"""Imitation requests and answers, as messages."""

from __future__ import annotations

import array
import dataclasses
from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import PoseArray
from spatial_relations_msgs.action import ImitateRelation
from spatial_relations_msgs.msg import Imitation, Move, MovePlan, PoseTarget
from std_msgs.msg import Header

from spatial_relations_ros.core import ImitationError, Scene
from spatial_relations_ros.imitation import (
    ImitationAnswer,
    ImitationOptions,
    ImitationProgress,
    ImitationResult,
    ObjectPlacement,
)
from spatial_relations_ros.ros.conversions import header_to_msg, pose_stamped, pose_to_msg


def options_from_request(
    request: Any, test: Scene, defaults: ImitationOptions
) -> ImitationOptions:
    """Options of an Imitate request or an ImitateRelation goal.

    Args:
        request: the message; zero and empty fields take the defaults.
        test: the test scene, for the ids in ``movable_ids``.
        defaults: from the node's parameters.

    Raises:
        ImitationError: for a movable id that is not a test object.
        ConfigError: for a time budget that is negative or not finite.
    """
    return dataclasses.replace(
        defaults,
        movable=_movable_roles(request.movable_ids, test),
        time_budget_sec=float(request.time_budget) or defaults.time_budget_sec,
        num_answers=int(request.num_answers) or defaults.num_answers,
        keep_heading=bool(request.keep_heading),
    )


def _movable_roles(movable_ids: Sequence[str], test: Scene) -> tuple[str, ...]:
    roles = dict(zip(test.object_ids, ('base', 'relative'), strict=True))
    unknown = [object_id for object_id in movable_ids if object_id not in roles]
    if unknown:
        raise ImitationError(
            f'movable_ids names {", ".join(unknown)}; the test objects are {", ".join(roles)}'
        )
    named = tuple(role for object_id, role in roles.items() if object_id in movable_ids)
    return named or ('relative',)


def target_to_msg(placement: ObjectPlacement, header: Header) -> PoseTarget:
    """PoseTarget.msg of one object's placement."""
    return PoseTarget(
        object_id=placement.object_id,
        current=pose_stamped(placement.current, header),
        target=pose_stamped(placement.target, header),
        approach=pose_stamped(placement.approach, header),
        reachable=bool(placement.reachable),
        penetration=float(placement.penetration),
        supported=bool(placement.supported),
    )


def answer_to_msg(answer: ImitationAnswer, header: Header) -> Imitation:
    """Imitation.msg of one answer."""
    return Imitation(
        targets=[target_to_msg(placement, header) for placement in answer.placements],
        distance=float(answer.distance),
        confidence=float(answer.confidence),
        feasible=bool(answer.feasible),
        violations=list(answer.violations),
    )


def plan_to_msg(answer: ImitationAnswer, header: Header) -> MovePlan:
    """MovePlan.msg of one answer."""
    placements = {placement.object_id: placement for placement in answer.placements}
    moves = [
        _move_to_msg(placements[move.object_id])
        if move.to_target
        else Move(object_id=move.object_id)
        for move in answer.order
    ]
    return MovePlan(header=header, moves=moves)


def _move_to_msg(placement: ObjectPlacement) -> Move:
    msg = Move(
        object_id=placement.object_id,
        to_target=True,
        target=pose_to_msg(placement.target),
        approach=pose_to_msg(placement.approach),
        approach_clear=bool(placement.approach_clear),
        has_grasp=placement.gripper_target is not None,
    )
    if placement.gripper_target is not None and placement.gripper_approach is not None:
        msg.gripper_target = pose_to_msg(placement.gripper_target)
        msg.gripper_approach = pose_to_msg(placement.gripper_approach)
    return msg


def targets_to_pose_array(answer: ImitationAnswer, header: Header) -> PoseArray:
    """The target poses of base and relative."""
    poses = [pose_to_msg(placement.target) for placement in answer.placements]
    return PoseArray(header=header, poses=poses)


def fill_result(message: Any, result: ImitationResult, test: Scene) -> Any:
    """Fills an Imitate response or an ImitateRelation result and returns it."""
    header = header_to_msg(test.stamp_ns, test.frame_id)
    message.success = bool(result.success)
    message.message = result.message
    message.answers = [answer_to_msg(answer, header) for answer in result.answers]
    message.distance_history = array.array('f', result.distance_history.tolist())
    message.initial_distance = float(result.initial_distance)
    message.duration = float(result.duration_sec)
    return message


def progress_to_feedback(progress: ImitationProgress, test: Scene) -> Any:
    """ImitateRelation feedback."""
    header = header_to_msg(test.stamp_ns, test.frame_id)
    return ImitateRelation.Feedback(
        step=int(progress.step),
        distance=float(progress.distance),
        feasible=bool(progress.feasible),
        best=answer_to_msg(progress.best, header),
    )
