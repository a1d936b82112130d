"""How every node's ``main`` starts, spins and ends."""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
from collections.abc import Callable, Sequence

import rclpy
from rclpy.executors import (
    Executor,
    ExternalShutdownException,
    MultiThreadedExecutor,
    SingleThreadedExecutor,
)

from spatial_relations_ros.core import SpatialRelationsError
from spatial_relations_ros.ros.relations_node import MAX_WAITING_REQUESTS, RelationsNode

# Threads are made when needed. Requests that wait hold one each; two nodes of a process may serve
# such requests, and what these wait for needs threads too.
NUM_THREADS = 2 * MAX_WAITING_REQUESTS + 8


class NodeThread:
    """Spins one node on a thread of its own, beside the executor of its process.

    Args:
        node: whose callbacks wait for nobody; from now on this object ends it.
    """

    def __init__(self, node: RelationsNode) -> None:
        self._node = node
        self._executor = SingleThreadedExecutor(context=node.context)
        self._executor.add_node(node)
        self._thread = threading.Thread(target=self._spin, name=node.get_name(), daemon=True)
        self._thread.start()

    def _spin(self) -> None:
        with contextlib.suppress(ExternalShutdownException):
            self._executor.spin()

    def close(self) -> None:
        """Ends the thread and the node; a second call does nothing."""
        if self._thread.is_alive():
            self._executor.shutdown(timeout_sec=5.0)
            self._thread.join()
        self._node.destroy_node()


def run_node(
    make_node: Callable[[], RelationsNode],
    arguments: Sequence[str] | None = None,
    *,
    may_wait: bool = True,
) -> int:
    """Runs a node until Ctrl-C, a termination signal or a shutdown of the context.

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
    exit_code = 0
    executor: Executor | None = None
    try:
        rclpy.init(args=None if arguments is None else list(arguments))
        executor = MultiThreadedExecutor(NUM_THREADS) if may_wait else SingleThreadedExecutor()
        executor.add_node(make_node())
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except SpatialRelationsError as error:
        print(f'cannot start: {error}', file=sys.stderr)
        exit_code = 2
    finally:
        # Ctrl-C under a launcher can arrive twice; the second must not cut this short.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        if executor is not None:
            nodes = executor.get_nodes()
            for node in nodes:
                if isinstance(node, RelationsNode):
                    node.close()
            executor.shutdown(timeout_sec=5.0)
            for node in nodes:
                node.destroy_node()
        rclpy.try_shutdown()
    return exit_code
