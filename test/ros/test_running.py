"""How nodes end: asked by a signal at any time, without anything that is used after its end."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import rclpy
from rclpy.action import ActionClient, ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions, get_current_signal_handlers_options
from spatial_relations_msgs.action import ImitateRelation
from std_srvs.srv import Trigger

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.nodes.scene_client import SCENE_PARAMETERS, call
from spatial_relations_ros.ros.domains import free_domain_id
from spatial_relations_ros.ros.parameters import ParameterSpec
from spatial_relations_ros.ros.relations_node import RelationsNode
from spatial_relations_ros.ros.running import SpinThread, run_node
from spatial_relations_ros.ros.waiting import NoAnswerError, sent_by, wait_for, wait_until

pytestmark = pytest.mark.ros

TIMEOUT_SEC = 60.0
SPECS = (
    *(spec for spec in SCENE_PARAMETERS if spec.name != 'service_timeout'),
    ParameterSpec('service_timeout', TIMEOUT_SEC, 'Seconds.'),
)


@pytest.fixture(autouse=True)
def _surroundings(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A domain for the test alone, and the signal handlers of before after it."""
    monkeypatch.setenv('ROS_DOMAIN_ID', str(free_domain_id()))
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def ask(number: signal.Signals) -> None:
    os.kill(os.getpid(), number)


class Waiting(RelationsNode):
    """Each of three timers waits for a service that nobody offers, then uses the node."""

    def __init__(self) -> None:
        super().__init__('waiting', SPECS)
        self.num_waiting = threading.Semaphore(0)
        self.ended: list[str] = []
        self.ended_at_destruction: list[str] | None = None
        self._client = self.create_client(Trigger, 'nobody', callback_group=self.requests_group)
        for _ in range(3):
            group = MutuallyExclusiveCallbackGroup()
            self.create_timer(0.01, self._wait, callback_group=group)

    def _wait(self) -> None:
        self.num_waiting.release()
        try:
            call(self, self._client, Trigger.Request())
        except NoAnswerError as error:
            self.diagnostics.publish()
            self.ended.append(str(error))

    def destroy_node(self) -> None:
        self.ended_at_destruction = list(self.ended)
        super().destroy_node()


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_nothing_of_a_node_runs_any_more_when_it_is_destroyed(
    number: signal.Signals, capfd: pytest.CaptureFixture[str]
) -> None:
    made: list[Waiting] = []

    def make() -> Waiting:
        made.append(Waiting())
        return made[0]

    def interrupt() -> None:
        assert wait_until(lambda: bool(made), TIMEOUT_SEC)
        for _ in range(3):
            made[0].num_waiting.acquire()
        ask(number)
        ask(number)  # as under a launcher

    threading.Thread(target=interrupt).start()
    start_sec = time.monotonic()
    assert run_node(make, []) == 0
    assert time.monotonic() - start_sec < TIMEOUT_SEC / 2.0, 'nobody waits for what will not come'
    ended = made[0].ended
    assert len(ended) >= 3
    assert set(ended) == {'the node is shutting down'}
    assert made[0].ended_at_destruction == ended
    assert capfd.readouterr().err == ''


class Plain(RelationsNode):
    """Does one thing soon after its start."""

    def __init__(self, act: Callable[[], Any]) -> None:
        super().__init__('plain', SPECS)
        self.is_destroyed = False
        self.create_timer(0.01, act)

    def destroy_node(self) -> None:
        self.is_destroyed = True
        super().destroy_node()


def run(act: Callable[[], Any], *, may_wait: bool, early: signal.Signals | None = None) -> Plain:
    made: list[Plain] = []

    def make() -> Plain:
        if early is not None:
            ask(early)
        made.append(Plain(act))
        return made[0]

    try:
        assert run_node(make, [], may_wait=may_wait) == 0
    finally:
        assert made[0].is_destroyed
    return made[0]


class Working(RelationsNode):
    """Works at a goal until it shuts down."""

    def __init__(self) -> None:
        super().__init__('working', SPECS)
        self._server = ActionServer(
            self, ImitateRelation, 'work', self._work, callback_group=self.requests_group
        )

    def _work(self, goal: ServerGoalHandle) -> ImitateRelation.Result:
        with self.place_for_request():
            goal.publish_feedback(ImitateRelation.Feedback())
            assert wait_until(lambda: self.is_closing, TIMEOUT_SEC)
        goal.succeed()
        return ImitateRelation.Result(message='the best so far')

    def destroy_node(self) -> None:
        self._server.destroy()
        super().destroy_node()


def test_a_goal_that_runs_is_answered_at_the_end() -> None:
    context = Context()
    rclpy.init(context=context)
    node = Node('asking', context=context)
    client = ActionClient(node, ImitateRelation, 'work')
    spinning = SpinThread(SingleThreadedExecutor(context=context), node)
    works = threading.Event()
    results: list[Any] = []

    def interrupt() -> None:
        try:
            assert client.wait_for_server(TIMEOUT_SEC)
            sent = sent_by(
                node.executor,
                lambda: client.send_goal_async(ImitateRelation.Goal(), lambda _: works.set()),
                TIMEOUT_SEC,
            )
            handle = wait_for(sent, TIMEOUT_SEC)
            results.append(sent_by(node.executor, handle.get_result_async, TIMEOUT_SEC))
            works.wait(TIMEOUT_SEC)
        finally:  # also when something fails: the node would run on
            ask(signal.SIGTERM)

    threading.Thread(target=interrupt).start()
    assert run_node(Working, []) == 0
    assert wait_for(results[0], TIMEOUT_SEC).result.message == 'the best so far'
    client.destroy()
    spinning.close()
    rclpy.shutdown(context=context)


either_executor = pytest.mark.parametrize('may_wait', [True, False])


@either_executor
def test_a_signal_during_the_start_is_obeyed_after_it(may_wait: bool) -> None:
    run(lambda: None, may_wait=may_wait, early=signal.SIGINT)


@either_executor
def test_it_ends_with_its_context(may_wait: bool) -> None:
    run(rclpy.shutdown, may_wait=may_wait)


@either_executor
def test_what_a_callback_raises_ends_the_node_and_is_told(may_wait: bool) -> None:
    with pytest.raises(ZeroDivisionError):
        run(lambda: 1 // 0, may_wait=may_wait)


def test_signals_do_not_reach_rclpy() -> None:
    """Its handlers end the context at once, on a thread of their own.

    On a busy machine that thread was still at the executor's guard conditions when these were
    destroyed, and the process ended with a segmentation fault.
    """
    seen: list[Any] = []

    def act() -> None:
        seen.append(get_current_signal_handlers_options())
        ask(signal.SIGINT)
        seen.append(rclpy.ok())

    run(act, may_wait=True)
    assert seen[:2] == [SignalHandlerOptions.NO, True]


def test_a_node_that_cannot_be_set_up_says_why(capsys: pytest.CaptureFixture[str]) -> None:
    def make() -> RelationsNode:
        raise ConfigError('no camera')

    assert run_node(make, []) == 2
    assert capsys.readouterr().err == 'cannot start: no camera\n'
