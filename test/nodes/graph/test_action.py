"""Imitation by the action."""

from __future__ import annotations

from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from demo_session import DemoSession
from ros_graph import ANSWER_SEC
from spatial_relations_msgs.action import ImitateRelation

from spatial_relations_ros.ros.waiting import wait_for

pytestmark = pytest.mark.ros


def test_the_action_gives_feedback_and_honours_cancel(session: DemoSession) -> None:
    client = session.graph.action(ImitateRelation, '/imitate_relation')
    feedback: list[Any] = []
    goal = ImitateRelation.Goal(
        reference_ids=session.reference_ids, test_ids=session.test_ids, time_budget=600.0
    )
    session.set_parameter('imitate_node', 'max_steps', 10_000)
    try:
        sent = session.graph.sent(
            lambda: client.send_goal_async(
                goal, feedback_callback=lambda item: feedback.append(item.feedback)
            )
        )
        handle = wait_for(sent, ANSWER_SEC)
        assert handle.accepted
        session.graph.wait(
            lambda: len(feedback) >= 5 and feedback[-1].step > 1, 'feedback of several steps'
        )
        cancelled = session.graph.sent(handle.cancel_goal_async)
        assert wait_for(cancelled, ANSWER_SEC).goals_canceling
        outcome = wait_for(session.graph.sent(handle.get_result_async), ANSWER_SEC)
    finally:
        session.set_parameter('imitate_node', 'max_steps', 4)
    assert outcome.status == GoalStatus.STATUS_CANCELED
    assert 'cancelled' in outcome.result.message
    # The best so far, not nothing.
    assert [target.object_id for target in outcome.result.answers[0].targets] == session.test_ids
    steps = [item.step for item in feedback]
    assert steps == sorted(steps)
    # It ended long before it would have by itself.
    assert steps[-1] < 5_000
    assert all(item.best.targets for item in feedback)
    client.destroy()


def test_the_action_ends_like_the_service(session: DemoSession) -> None:
    client = session.graph.action(ImitateRelation, '/imitate_relation')
    goal = ImitateRelation.Goal(
        reference_ids=session.reference_ids, test_ids=session.test_ids, time_budget=600.0
    )
    sent = session.graph.sent(lambda: client.send_goal_async(goal))
    handle = wait_for(sent, ANSWER_SEC)
    outcome = wait_for(session.graph.sent(handle.get_result_async), ANSWER_SEC)
    expected = session.imitate(time_budget=600.0)
    assert outcome.result.message == expected.message
    wanted = GoalStatus.STATUS_SUCCEEDED if expected.success else GoalStatus.STATUS_ABORTED
    assert outcome.status == wanted
    assert outcome.result.answers[0].distance == pytest.approx(
        expected.answers[0].distance, rel=1e-3
    )
    client.destroy()


def test_a_result_that_was_told_is_forgotten(session: DemoSession) -> None:
    """Goals are kept with their scenes until then: a robot asks for very many in a week."""
    client = session.graph.action(ImitateRelation, '/imitate_relation')
    goal = ImitateRelation.Goal(reference_ids=['nobody', 'else'], test_ids=session.test_ids)
    sent = session.graph.sent(lambda: client.send_goal_async(goal))
    handle = wait_for(sent, ANSWER_SEC)

    def status() -> int:
        return wait_for(session.graph.sent(handle.get_result_async), ANSWER_SEC).status

    assert status() == GoalStatus.STATUS_ABORTED
    session.graph.wait(lambda: status() == GoalStatus.STATUS_UNKNOWN, 'the end of its memory')
    client.destroy()
