"""Imitation requests and answers as messages."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message
from spatial_relations_msgs.action import ImitateRelation
from spatial_relations_msgs.srv import Imitate

from spatial_relations_ros.core import ConfigError, ImitationError, Pose, Scene, SceneObject
from spatial_relations_ros.imitation import (
    ImitationAnswer,
    ImitationOptions,
    ImitationProgress,
    ImitationResult,
    Move,
    ObjectPlacement,
)
from spatial_relations_ros.perception.messages import read_pose
from spatial_relations_ros.ros.conversions import header_to_msg
from spatial_relations_ros.ros.imitation_messages import (
    fill_result,
    options_from_request,
    plan_to_msg,
    progress_to_feedback,
    targets_to_pose_array,
)

POINTS = np.eye(4, 3, dtype=np.float32)


def scene() -> Scene:
    base = SceneObject('tray', POINTS, Pose(np.array([1.0, 0.0, 0.0])))
    relative = SceneObject('mug', POINTS, Pose(np.array([2.0, 0.0, 0.0])))
    return Scene(base, relative, stamp_ns=5, frame_id='map')


def answer() -> ImitationAnswer:
    placements = tuple(
        ObjectPlacement(
            item.object_id,
            item.world_from_object,
            Pose(item.world_from_object.translation + [0.0, 1.0, 0.0]),
            Pose(item.world_from_object.translation + [0.0, 1.0, 0.1]),
            reachable=True,
            penetration=0.003,
            supported=idx == 0,
        )
        for idx, item in enumerate(scene().objects)
    )
    return ImitationAnswer(placements, 0.25, 0.9, False, ('mug is not supported',))  # type: ignore[arg-type]


def test_an_empty_request_takes_the_defaults() -> None:
    defaults = ImitationOptions(time_budget_sec=7.0, max_steps=12)
    assert options_from_request(Imitate.Request(), scene(), defaults) == defaults


def test_a_request_sets_the_options() -> None:
    request = ImitateRelation.Goal(
        movable_ids=['mug', 'tray'], time_budget=2.0, num_answers=3, keep_heading=True
    )
    options = options_from_request(request, scene(), ImitationOptions())
    assert options.movable == ('base', 'relative')
    assert (options.time_budget_sec, options.num_answers, options.keep_heading) == (2.0, 3, True)


def test_only_test_objects_can_move() -> None:
    request = Imitate.Request(movable_ids=['tray', 'spoon'])
    with pytest.raises(ImitationError, match='names spoon; the test objects are tray, mug'):
        options_from_request(request, scene(), ImitationOptions())


def test_a_negative_budget_is_refused() -> None:
    with pytest.raises(ConfigError, match='time_budget_sec'):
        options_from_request(Imitate.Request(time_budget=-1.0), scene(), ImitationOptions())


def test_results_survive_the_wire() -> None:
    result = ImitationResult(
        True, 'fine', (answer(),), np.array([0.5, 0.25], dtype=np.float32), 0.5, 1.5, 2
    )
    filled = fill_result(Imitate.Response(), result, scene())
    back = deserialize_message(serialize_message(filled), Imitate.Response)
    assert (back.success, back.message, back.duration) == (True, 'fine', 1.5)
    assert list(back.distance_history) == [0.5, 0.25]
    tray, mug = back.answers[0].targets
    assert (tray.object_id, mug.object_id) == ('tray', 'mug')
    assert (tray.supported, mug.supported) == (True, False)
    assert mug.penetration == pytest.approx(0.003)
    assert mug.target.header.frame_id == 'map'
    assert read_pose(mug.target.pose).translation.tolist() == [2.0, 1.0, 0.0]
    assert read_pose(mug.approach.pose).translation.tolist() == [2.0, 1.0, 0.1]
    assert list(back.answers[0].violations) == ['mug is not supported']


def test_service_and_action_results_are_filled_alike() -> None:
    result = ImitationResult(False, 'no', (), np.zeros(1, dtype=np.float32), 0.5, 0.1, 0)
    for message in (Imitate.Response(), ImitateRelation.Result()):
        assert fill_result(message, result, scene()).message == 'no'


def test_the_plan_of_moves() -> None:
    base, relative = answer().placements
    held = dataclasses.replace(
        relative, gripper_target=Pose(np.array([0.0, 0.0, 1.0])), gripper_approach=Pose()
    )
    ordered = dataclasses.replace(
        answer(),
        placements=(base, held),
        order=(Move('mug', False), Move('tray'), Move('mug')),
    )
    plan = plan_to_msg(ordered, header_to_msg(5, 'map'))
    assert [(move.object_id, move.to_target) for move in plan.moves] == [
        ('mug', False),
        ('tray', True),
        ('mug', True),
    ]
    assert [move.has_grasp for move in plan.moves] == [False, False, True]
    assert plan.moves[1].approach.position.z == pytest.approx(0.1)
    assert plan.moves[2].gripper_target.position.z == 1.0
    assert plan.header.frame_id == 'map'
    assert plan_to_msg(answer(), header_to_msg(5, 'map')).moves == []


def test_feedback_and_pose_array() -> None:
    feedback = progress_to_feedback(ImitationProgress(4, 0.5, False, answer()), scene())
    assert (feedback.step, feedback.best.distance) == (4, 0.25)
    poses = targets_to_pose_array(answer(), header_to_msg(5, 'map'))
    assert [pose.position.x for pose in poses.poses] == [1.0, 2.0]
    assert poses.header.frame_id == 'map'
