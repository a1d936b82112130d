"""How every node's ``main`` starts, spins and ends."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TypeVar

import rclpy
from rclpy.executors import (
    Executor,
    ExternalShutdownException,
    MultiThreadedExecutor,
    SingleThreadedExecutor,
)
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from spatial_relations_ros.core import SpatialRelationsError
from spatial_relations_ros.ros.relations_node import MAX_WAITING_REQUESTS, RelationsNode
from spatial_relations_ros.ros.stop_request import StopRequest
from spatial_relations_ros.ros.waiting import wait_until

AnyNode = TypeVar('AnyNode', bound=Node)

# Threads are made when needed. Requests that wait hold one each; two nodes of a process may serve
# such requests, and what these wait for needs threads too.
NUM_THREADS = 2 * MAX_WAITING_REQUESTS + 8
# Longest wait for requests that are asked to end, before the spinning ends.
LAST_ANSWERS_SEC = 5.0


class WaitingExecutor(MultiThreadedExecutor):
    """An executor of several threads that waits for all of them at its end.

    That of rclpy 7 leaves them behind (github.com/ros2/rclpy/pull/1309): callbacks would go on
    with nodes that are being destroyed.
    """

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """Ends it after what its threads do; to be called when it no longer spins."""
        self._executor.shutdown(wait=True)
        return bool(super().shutdown(timeout_sec))


class SpinThread:
    """Spins nodes on a thread of its own, and from now on ends them.

    Args:
        executor: spins them; nodes may be added to it until the end.
        node: the first of them.
        on_end: called on that thread when it ends, asked or not.

    Attributes:
        error: what a callback raised, which ends the thread.
    """

    def __init__(
        self, executor: Executor, node: Node, on_end: Callable[[], None] = lambda: None
    ) -> None:
        self.error: Exception | None = None
        self._executor, self._on_end = executor, on_end
        self._is_closing = threading.Event()
        executor.add_node(node)
        self._thread = threading.Thread(target=self._spin, name=node.get_name(), daemon=True)
        self._thread.start()

    def _spin(self) -> None:
        try:
            while not self._is_closing.is_set() and self._executor.context.ok():
                self._executor.spin_once()
        except ExternalShutdownException:
            pass
        except Exception as error:  # for whoever ends this thread
            self.error = error
        finally:
            self._on_end()

    def close(self) -> None:
        """Ends all in the one order in which nothing is used after its end.

        What the nodes run beside their callbacks and what callbacks wait for; while that ends
        and clients get their answers, the nodes still spin. Then the spinning, then the callbacks
        that run. Nobody uses the nodes any more when they are destroyed. A second call does
        nothing.
        """
        if self._is_closing.is_set():
            return
        nodes = self._close_nodes()
        served = [node for node in nodes if isinstance(node, RelationsNode)]
        self._wait(lambda: all(node.is_idle for node in served))
        self._work_off()
        self._is_closing.set()
        # Work ends the wait for work; shutdown would take the executor apart beneath its thread
        # (github.com/ros2/rclpy/issues/968).
        self._executor.create_task(lambda: None)
        self._thread.join()
        nodes = self._close_nodes()  # once more: callbacks may have added some
        self._executor.shutdown()
        for node in nodes:
            node.destroy_node()

    def _wait(self, condition: Callable[[], bool]) -> None:
        wait_until(lambda: condition() or not self._thread.is_alive(), LAST_ANSWERS_SEC)

    def _work_off(self) -> None:
        """Waits until tasks that are queued have begun, such as sending the result of an action.

        The executor hands out the newest first; when a task comes that was made after another
        one had its turn, those before that have been handed out.
        """
        for _ in range(2):
            turn = threading.Event()
            self._executor.create_task(turn.set)
            self._wait(turn.is_set)

    def _close_nodes(self) -> list[Node]:
        nodes: list[Node] = self._executor.get_nodes()
        for node in nodes:
            if isinstance(node, RelationsNode):
                node.close()
        return nodes


def spin_alone(node: RelationsNode) -> SpinThread:
    """Spins a node, whose callbacks wait for nobody, beside the executor of its process."""
    return SpinThread(SingleThreadedExecutor(context=node.context), node)


@contextmanager
def spun(make_node: Callable[[], AnyNode], domain_id: int | None = None) -> Iterator[AnyNode]:
    """A node by which a program talks to others, spun beside it until the block is left.

    Signals stay with the program: Ctrl-C raises KeyboardInterrupt in it, and the node lives until
    the block ends.

    Args:
        make_node: makes it once rclpy is initialised, without arguments of a command line.
        domain_id: of its graph; ROS_DOMAIN_ID by default.
    """
    rclpy.init(args=[], domain_id=domain_id, signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = make_node()
        spinning = SpinThread(SingleThreadedExecutor(), node)
        try:
            yield node
        finally:
            spinning.close()
    finally:
        rclpy.try_shutdown()


def run_node(
    make_node: Callable[[], RelationsNode],
    arguments: Sequence[str] | None = None,
    *,
    may_wait: bool = True,
) -> int:
    """Runs a node until Ctrl-C, a termination signal or a shutdown of the context.

    A signal only asks: the context lives until the nodes have ended. rclpy's own handlers shut it
    down at once, beneath whatever runs, and interrupt the main thread wherever it is. A second
    signal changes nothing, and one that comes during the start is obeyed after it.

    Args:
        make_node: makes the node once rclpy is initialised.
        arguments: the command line, ``sys.argv`` by default.
        may_wait: whether callbacks wait for others, so that they need threads of their own. The
            executor of one thread costs a fraction where many messages come: that of several
            hands a callback out again and again until a thread has taken it up
            (github.com/ros2/rclpy/issues/1452).

    Returns:
        Exit code: 0 after a requested end, 2 when the node could not be set up.
    """
    stop = StopRequest.by_signals()
    try:
        rclpy.init(
            args=None if arguments is None else list(arguments),
            signal_handler_options=SignalHandlerOptions.NO,
        )
        try:
            node = make_node()
        except SpatialRelationsError as error:
            print(f'cannot start: {error}', file=sys.stderr)
            return 2
        executor = WaitingExecutor(NUM_THREADS) if may_wait else SingleThreadedExecutor()
        spinning = SpinThread(executor, node, on_end=stop.set)
        stop.wait()
        spinning.close()
        if spinning.error is not None:
            raise spinning.error
    finally:
        rclpy.try_shutdown()
    return 0
