"""Goals of the action ``imitate_relation``, one at a time."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from rclpy.action import ActionClient
from rclpy.task import Future
from spatial_relations_msgs.action import ImitateRelation

from spatial_relations_ros.ros.relations_node import RelationsNode
from spatial_relations_ros.ros.waiting import (
    SHUTTING_DOWN,
    BusyError,
    NoAnswerError,
    wait_for,
    wait_until,
)

POLL_SEC = 0.1
# So long the imitate node may be out of sight before its goal is given up.
GONE_SEC = 3.0


class _Client(ActionClient):
    """An action client that takes no answer while a request is being sent.

    rclpy knows of a request a little after it has been sent; what is answered before that on
    another thread is lost (https://github.com/ros2/rclpy/issues/1123).

    Attributes:
        sending: held by who sends.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        self.sending = threading.Lock()
        super().__init__(*arguments, **options)

    def take_data(self) -> Any:
        """Takes what has come, on a thread of the executor."""
        with self.sending:
            return super().take_data()


class Goals:
    """A client of the action that does not wait for a server that is gone.

    Args:
        node: with the parameters ``imitate_relation``, ``service_timeout`` and ``answer_timeout``.
    """

    def __init__(self, node: RelationsNode) -> None:
        self._node = node
        name = node.parameters.text('imitate_relation')
        self._client = _Client(node, ImitateRelation, name, callback_group=node.requests_group)
        self._status = f'{node.resolve_service_name(name)}/_action/status'
        self._lock = threading.Lock()
        self._handle: Any = None
        self._is_cancelled = False

    def begin(self) -> None:
        """Forgets what was cancelled before."""
        with self._lock:
            self._is_cancelled = False

    def cancel(self) -> None:
        """Asks for the best answer so far; before a goal is accepted, as soon as it is."""
        with self._lock:
            self._is_cancelled = True
            if self._handle is not None:
                self._send(self._handle.cancel_goal_async)

    def destroy(self) -> None:
        """Destroys the client, before its node and when nobody waits in ``result``."""
        self._client.destroy()

    def result(self, goal: ImitateRelation.Goal, on_feedback: Callable[[Any], None]) -> Any:
        """Sends a goal and waits for its result; what is given up is cancelled.

        Args:
            goal: of the action.
            on_feedback: gets the feedback messages, on a thread of the executor.

        Raises:
            NoAnswerError: when there is no server, it goes away, even if another one takes its
                place, or its answer does not come in time, or the node is shutting down.
            BusyError: when the server does not take the goal.
        """
        timeout_sec = self._node.parameters.number('service_timeout')
        wait_until(lambda: self._node.is_closing or self._client.server_is_ready(), timeout_sec)
        if self._node.is_closing:
            raise NoAnswerError(SHUTTING_DOWN)
        if not self._client.server_is_ready():
            raise NoAnswerError('no imitate node: is it running, and in the same namespace?')
        sent = self._send(lambda: self._client.send_goal_async(goal, on_feedback))
        handle = wait_for(sent, timeout_sec, lambda: self._node.is_closing)
        if not handle.accepted:
            raise BusyError('the imitate node does not take the request now; try again later')
        with self._lock:
            self._handle = handle
            if self._is_cancelled:
                self._send(handle.cancel_goal_async)
        try:
            return self._wait_for_result(self._send(handle.get_result_async))
        except NoAnswerError:
            self._send(handle.cancel_goal_async)
            raise
        finally:
            with self._lock:
                self._handle = None

    def _send(self, send: Callable[[], Future]) -> Future:
        with self._client.sending:
            return send()

    def _wait_for_result(self, future: Any) -> Any:
        """Waits as long as there is the node that could answer."""
        done = threading.Event()
        future.add_done_callback(lambda _: done.set())
        start_sec = seen_sec = time.monotonic()
        timeout_sec = self._node.parameters.number('answer_timeout')
        servers = self._servers()
        while not done.wait(POLL_SEC):
            now_sec = time.monotonic()
            # One that was started anew knows nothing of the goal.
            if servers & self._servers():
                seen_sec = now_sec
            if self._node.is_closing:
                raise NoAnswerError(SHUTTING_DOWN)
            if now_sec - seen_sec > GONE_SEC:
                raise NoAnswerError('the imitate node went away while it worked')
            if now_sec - start_sec > timeout_sec:
                raise NoAnswerError(f'the imitate node gave no answer within {timeout_sec:g} s')
        return future.result().result

    def _servers(self) -> set[bytes]:
        """What identifies the servers that are there now."""
        found = self._node.get_publishers_info_by_topic(self._status)
        return {bytes(endpoint.endpoint_gid) for endpoint in found}
