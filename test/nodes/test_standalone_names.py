"""What imitate_node starts in its own process: under which names, and when it cannot be set up."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor

from spatial_relations_ros.nodes.imitate_node import ImitateNode
from spatial_relations_ros.ros.domains import free_domain_id
from spatial_relations_ros.ros.relations_node import RelationsNode
from spatial_relations_ros.ros.waiting import wait_until

pytestmark = pytest.mark.ros

WAIT_SEC = 60.0


class Alone:
    """imitate_node in this process, with what it says of its standalone part."""

    def __init__(self, node: ImitateNode) -> None:
        self.node = node
        self.states: list[DiagnosticStatus] = []
        node.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)

    def _on_diagnostics(self, msg: DiagnosticArray) -> None:
        self.states += [item for item in msg.status if item.name == 'imitate_node: standalone']

    def wait_for_state(self, words: str) -> DiagnosticStatus:
        found: list[DiagnosticStatus] = []

        def is_there() -> bool:
            found.extend(item for item in self.states if words in item.message)
            return bool(found)

        assert wait_until(is_there, WAIT_SEC), [item.message for item in self.states]
        return found[0]

    def node_names(self) -> set[str]:
        return {
            f'{namespace.rstrip("/")}/{name}'
            for name, namespace in self.node.get_node_names_and_namespaces()
        }


@contextmanager
def started(*parameters: str) -> Iterator[Alone]:
    context = Context()
    arguments = [part for item in parameters for part in ('-p', item)]
    rclpy.init(
        args=['--ros-args', '-p', 'standalone:=true', *arguments],
        context=context,
        domain_id=free_domain_id(),
    )
    executor = MultiThreadedExecutor(8, context=context)
    node = ImitateNode(context=context)
    alone = Alone(node)
    executor.add_node(node)

    def spin() -> None:
        with suppress(ExternalShutdownException):
            executor.spin()

    thread = threading.Thread(target=spin)
    thread.start()
    try:
        yield alone
    finally:
        nodes = executor.get_nodes()
        for item in nodes:
            assert isinstance(item, RelationsNode)
            item.close()
        executor.shutdown()
        thread.join()
        for item in nodes:
            item.destroy_node()
        rclpy.shutdown(context=context)


def test_nodes_get_the_names_under_which_they_are_asked(weights: Path) -> None:
    with started(f'weights:={weights}', 'perception:=eyes', 'metric:=/cell/judge') as alone:
        alone.wait_for_state('on: ')
        expected = {'/imitate_node', '/eyes', '/cell/judge'}
        assert wait_until(lambda: alone.node_names() == expected, WAIT_SEC), alone.node_names()


@pytest.mark.parametrize('bad', ["pose_topics:=['/']", 'publish_rate:=-1.0'])
def test_a_part_that_cannot_be_set_up_is_an_error_and_leaves_nothing(
    weights: Path, bad: str
) -> None:
    with started(f'weights:={weights}', bad) as alone:
        state = alone.wait_for_state(bad.partition(':')[0])
        assert state.level == DiagnosticStatus.ERROR
        gone = wait_until(lambda: alone.node_names() == {'/imitate_node'}, WAIT_SEC)
        assert gone, alone.node_names()
