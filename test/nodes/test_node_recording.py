"""The parameter ``rerun`` of nodes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from rclpy.context import Context

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.nodes.node_recording import RERUN, NodeRecording, log_frame
from spatial_relations_ros.perception.border import FrameResult
from spatial_relations_ros.ros.domains import free_domain_id
from spatial_relations_ros.ros.relations_node import RelationsNode

Make = Callable[[str, str], RelationsNode]


@pytest.fixture
def make() -> Iterator[Make]:
    context = Context()
    rclpy.init(context=context, domain_id=free_domain_id())
    nodes: list[RelationsNode] = []

    def make_node(name: str, target: str) -> RelationsNode:
        arguments = ['--ros-args', '-p', f'rerun:={target}'] if target else []
        nodes.append(RelationsNode(name, (RERUN,), context=context, cli_args=arguments))
        return nodes[-1]

    yield make_node
    for node in nodes:
        node.destroy_node()
    rclpy.shutdown(context=context)


def test_nodes_of_one_process_share_a_file(make: Make, solids: Any, tmp_path: Path) -> None:
    rerun = pytest.importorskip('rerun', reason='needs rerun-sdk (extra viz)')
    path = tmp_path / 'out.rrd'
    eyes, judge = (NodeRecording(make(name, str(path))) for name in ('eyes', 'judge'))
    assert eyes.is_on
    seen = {'box': solids.box('box', (0.1, 0.1, 0.1), (0.0, 0.0, 0.05))}
    result = FrameResult(1_500_000_000, 'world', seen, {'cup': 'it has no support'})
    eyes.record(result.stamp_ns, lambda recording: log_frame(recording, result))
    eyes.close()
    judge.record(2_000_000_000, lambda recording: recording.log_number(('distance',), 0.5))
    judge.close()
    judge.close()
    chunks = rerun.chunk.RrdReader(str(path)).stream().to_chunks()
    entities = {chunk.entity_path for chunk in chunks}
    assert {'/objects/box', '/log/cup', '/distance'} <= entities


def test_what_goes_wrong_is_reported_and_ends_nothing(make: Make, tmp_path: Path) -> None:
    pytest.importorskip('rerun', reason='needs rerun-sdk (extra viz)')
    node = make('eyes', str(tmp_path / 'out.rrd'))
    recording = NodeRecording(node)
    recording.record(0, lambda to: to.log_number(('distance',), 'much'))  # type: ignore[arg-type]
    recording.record(0, lambda to: to.log_number(('distance',), 1.0))
    recording.close()


def test_without_the_parameter_nothing_is_needed(make: Make) -> None:
    recording = NodeRecording(make('eyes', ''))
    assert not recording.is_on
    recording.record(0, lambda to: to.log_number(('distance',), 1.0))
    recording.close()


def test_a_target_that_is_none_is_refused_at_start(make: Make, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r'ends with \.rrd'):
        NodeRecording(make('eyes', str(tmp_path / 'out.mp4')))
