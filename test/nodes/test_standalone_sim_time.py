"""imitate_node alone on simulated time: a clock that stands still, and one that begins late."""

from __future__ import annotations

import pytest
from ros_graph import START_SEC, Graph
from rosgraph_msgs.msg import Clock

from spatial_relations_ros.ros import qos

pytestmark = pytest.mark.ros

MAX_DISCOVERY_SEC = 60.0


def start(graph: Graph, namespace: str, discovery_sec: float, *arguments: str) -> None:
    graph.processes.start(
        'imitate_node',
        parameters={'use_sim_time': True, 'discovery_time': discovery_sec},
        arguments=['-r', f'__ns:={namespace}', *arguments],
        name=f'imitate_node_{namespace[1:]}',
    )


def said(graph: Graph, namespace: str) -> str:
    """What the node says of perception and metric, on /diagnostics."""
    return graph.diagnostic(f'{namespace[1:]}/imitate_node: standalone')['message']


def test_it_decides_although_no_clock_runs(graph: Graph) -> None:
    start(graph, '/still', 0.5, '-r', '/clock:=/no_clock')
    graph.wait(
        lambda: said(graph, '/still').startswith('on: '), 'perception of its own', START_SEC
    )
    graph.processes.end('imitate_node_still')


def test_a_clock_that_begins_does_not_end_the_search_for_others(graph: Graph) -> None:
    start(graph, '/late', MAX_DISCOVERY_SEC)
    publisher = graph.node.create_publisher(Clock, '/clock', qos.CLOCK)
    now = Clock()
    now.clock.sec = 5000
    graph.wait(lambda: publisher.get_subscription_count() > 0, 'the node', START_SEC)
    name = 'late/imitate_node: standalone'
    for _ in range(3):  # diagnostics come once a second, the node decides ten times as often
        seen = graph.diagnostics.get(name)
        publisher.publish(now)
        now.clock.sec += 1
        graph.wait(lambda: graph.diagnostics.get(name) is not seen, 'its next word')  # noqa: B023
    assert said(graph, '/late') == 'looking for a perception node'
    graph.processes.start(
        'perception_node', arguments=['-r', '__ns:=/late'], name='perception_late'
    )
    graph.wait(lambda: said(graph, '/late').startswith('off: '), 'the other node', START_SEC)
