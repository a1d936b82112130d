"""Imitation by the service, with all that is published of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from demo_session import DemoSession
from spatial_relations_msgs.msg import Scene as SceneMsg

from spatial_relations_ros.core import Pose
from spatial_relations_ros.perception.messages import read_pose

pytestmark = pytest.mark.ros


def test_imitate_answers_and_publishes_the_targets(session: DemoSession) -> None:
    session.targets.clear(), session.single_targets.clear(), session.imitations.clear()
    response = session.imitate()
    assert response.answers, response.message
    best = response.answers[0]
    base, relative = best.targets
    assert [base.object_id, relative.object_id] == session.test_ids
    assert best.distance < response.initial_distance
    assert response.distance_history[0] == pytest.approx(response.initial_distance)
    session.graph.wait(
        lambda: bool(session.targets and session.single_targets and session.imitations), 'targets'
    )
    assert session.targets[-1].header.frame_id == session.plan.world_frame
    published = [read_pose(pose) for pose in session.targets[-1].poses]
    for pose, target in zip(published, (base, relative), strict=True):
        assert pose.is_close(read_pose(target.target.pose))
    assert read_pose(session.single_targets[-1].pose).is_close(published[1])
    assert session.imitations[-1].distance == pytest.approx(best.distance)
    # Only the relative object may move unless the request says otherwise.
    assert published[0].is_close(read_pose(base.current.pose))
    assert not published[1].is_close(read_pose(relative.current.pose))


def test_the_gripper_and_the_order_of_moves_are_published(session: DemoSession) -> None:
    session.grippers.clear(), session.plans.clear()
    response = session.imitate()
    assert response.answers, response.message
    session.graph.wait(lambda: bool(session.grippers and session.plans), 'gripper and plan')
    target = response.answers[0].targets[1]
    grasp = Pose(np.array([0.0, 0.0, 0.1]), np.array([0.0, 1.0, 0.0, 0.0]))
    gripper = read_pose(session.grippers[-1].pose)
    assert gripper.is_close(read_pose(target.target.pose) @ grasp)
    (move,) = session.plans[-1].moves
    assert (move.object_id, move.to_target, move.has_grasp) == (session.test_ids[1], True, True)
    assert read_pose(move.gripper_target).is_close(gripper)
    assert read_pose(move.approach).is_close(read_pose(target.approach.pose))


def test_only_what_may_move_moves(session: DemoSession) -> None:
    base_id, relative_id = session.test_ids
    response = session.imitate(movable_ids=[base_id])
    base, relative = response.answers[0].targets
    assert (base.object_id, relative.object_id) == (base_id, relative_id)
    assert read_pose(relative.target.pose).is_close(read_pose(relative.current.pose))


def test_old_scenes_are_refused(session: DemoSession) -> None:
    session.set_parameter('perception_node', 'max_age', 0.001)
    try:
        response = session.imitate()
    finally:
        session.set_parameter('perception_node', 'max_age', 0.0)
    assert not response.success
    assert 'max_age is 0.001 s' in response.message
    assert session.plan.points_topic in response.message


@pytest.mark.parametrize(
    ('fields', 'words'),
    [
        ({'test_ids': ['tray', 'teapot']}, ['teapot', 'known objects', 'mug']),
        ({'test_ids': ['mug', 'mug']}, ['two different objects']),
        ({'test_ids': ['mug']}, ['two object ids', '[base, relative]']),
        ({'test_ids': []}, ['test: nothing is given']),
        ({'reference_ids': []}, ['reference: nothing is given']),
        ({'reference_name': 'on_the_moon', 'reference_ids': []}, ['on_the_moon']),
        ({'reference_name': 'both'}, ['only one']),
        ({'movable_ids': ['spoon']}, ['spoon', 'test objects are']),
        ({'time_budget': -1.0}, ['time_budget']),
        ({'test_scene': [SceneMsg(), SceneMsg()], 'test_ids': []}, ['2 scenes']),
        ({'test_scene': [SceneMsg()], 'test_ids': []}, ['no field x']),
    ],
)
def test_a_request_that_cannot_be_served_says_why(
    session: DemoSession, fields: dict[str, Any], words: list[str]
) -> None:
    response = session.imitate(**fields)
    assert not response.success
    assert not response.answers
    for word in words:
        assert word in response.message
