"""How every node's ``main`` starts, spins and ends."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Sequence

import rclpy
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor

from spatial_relations_ros.core import SpatialRelationsError
from spatial_relations_ros.ros.relations_node import MAX_WAITING_REQUESTS, RelationsNode

# Threads are made when needed. Requests that wait hold one each; two nodes of a process may serve
# such requests, and what these wait for needs threads too.
NUM_THREADS = 2 * MAX_WAITING_REQUESTS + 8


def run_node(
    make_node: Callable[[], RelationsNode], arguments: Sequence[str] | None = None
) -> int:
    """Runs a node until Ctrl-C, a termination signal or a shutdown of the context.

    Args:
        make_node: makes the node once rclpy is initialised.
        arguments: the command line, ``sys.argv`` by default.

    Returns:
        Exit code: 0 after a requested end, 2 when the node could not be set up.
    """
    exit_code = 0
    executor: MultiThreadedExecutor | None = None
    try:
        rclpy.init(args=None if arguments is None else list(arguments))
        executor = MultiThreadedExecutor(NUM_THREADS)
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
