"""perception_node while it runs: parameters are changed, it is reset."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from faults.cell import Cell
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import DescribeParameters, SetParameters
from rclpy.parameter import get_parameter_value
from ros_graph import Graph, running_graph
from std_srvs.srv import Trigger

from spatial_relations_ros.core import Pose
from spatial_relations_ros.ros.conversions import pose_to_msg

pytestmark = pytest.mark.ros

NODE = '/perception_node'


@pytest.fixture(scope='module')
def cell(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cell]:
    for graph in running_graph(tmp_path_factory.mktemp('graph')):
        yield Cell(graph, tmp_path_factory.mktemp('models'), max_age=0.0)


def set_parameter(graph: Graph, name: str, text: str) -> str:
    """Sets a parameter as ``ros2 param set`` does; empty when accepted, else the reason."""
    value: ParameterValue = get_parameter_value(text)
    result = graph.call(
        SetParameters, f'{NODE}/set_parameters', parameters=[Parameter(name=name, value=value)]
    ).results[0]
    return '' if result.successful else str(result.reason)


def test_what_cannot_be_is_refused_with_the_reason_and_changes_nothing(cell: Cell) -> None:
    cell.wait_well(150.0)
    assert 'out of range Min: 0.0, Max: 1.0' in set_parameter(cell.graph, 'min_support', '1.5')
    assert 'expected "base/relative"' in set_parameter(cell.graph, 'pairs', "['box']")
    assert 'read-only' in set_parameter(cell.graph, 'world_frame', 'map')
    described = cell.graph.call(
        DescribeParameters, f'{NODE}/describe_parameters', names=['world_frame', 'min_support']
    ).descriptors
    assert [item.read_only for item in described] == [True, False]
    assert described[0].additional_constraints == 'read-only: set at start'
    cell.wait_well()


def test_limits_hold_from_the_next_cloud_on(cell: Cell) -> None:
    def show_beside() -> None:
        stamp_ns = cell.tick()
        tracks = cell.table.tracks(stamp_ns)
        tracks.objects[1].pose = pose_to_msg(Pose([0.1, -0.02, 0.25]))  # the post, off by 18 cm
        cell.tracks.publish(tracks)
        cell.clouds.publish(cell.table.cloud(stamp_ns))

    cell.wait_refused('post', show_beside)
    assert set_parameter(cell.graph, 'min_support', '0.0') == ''  # believes every tracker

    def is_believed() -> bool:
        show_beside()
        return bool(cell.ask().success)

    cell.graph.wait(is_believed, f'belief ({cell.last.message})')
    assert set_parameter(cell.graph, 'min_support', '0.4') == ''
    cell.wait_refused('post: tracked pose has no support', show_beside)
    assert set_parameter(cell.graph, 'pose_wait', '0.0') == ''
    cell.wait_well()


def test_a_reset_forgets_what_was_seen_and_counts_from_zero(cell: Cell) -> None:
    cell.wait_well()
    answer = cell.graph.call(Trigger, f'{NODE}/reset')
    assert answer.success
    assert answer.message.startswith('forgotten: objects, tracked poses')
    assert 'no point cloud that can be read has arrived' in cell.ask().message
    cell.graph.wait(lambda: cell.diagnostic('clouds').get('handled') == '0', 'the count')
    # A clock that was set back needs no patience any more.
    cell.stamp_ns -= 10**12
    cell.wait_well()
    cell.graph.wait(lambda: int(cell.diagnostic('clouds').get('handled', 0)) > 0, 'the count')
    assert float(cell.diagnostic('clouds')['latency_median_ms']) > 0.0
