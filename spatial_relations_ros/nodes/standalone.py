"""imitate_node alone: perception and metric in its own process."""

from __future__ import annotations

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup

from spatial_relations_ros.core import SpatialRelationsError
from spatial_relations_ros.nodes.metric_node import MetricNode
from spatial_relations_ros.nodes.model_host import ModelHost
from spatial_relations_ros.nodes.perception_node import PerceptionNode
from spatial_relations_ros.nodes.scene_client import SceneClient
from spatial_relations_ros.ros.diagnostics import OK, State
from spatial_relations_ros.ros.relations_node import RelationsNode

PERIOD_SEC = 0.1


def _named(name: str) -> list[str]:
    """Keeps a node's name when the process was given another one with ``-r __node:=``."""
    return ['--ros-args', '-r', f'__node:={name}']


class Standalone:
    """Decides once, after start, whether perception and metric run in this process.

    A timer decides, not the constructor: finding other nodes takes time.
    """

    def __init__(self, node: RelationsNode, host: ModelHost, scenes: SceneClient) -> None:
        self._node, self._host, self._scenes = node, host, scenes
        self._mode = node.parameters.text('standalone')
        self._end_ns = node.get_clock().now().nanoseconds + round(
            1e9 * node.parameters.number('discovery_time')
        )
        self._state = State(OK, 'looking for a perception node')
        node.diagnostics.add_state('standalone', lambda: self._state)
        self._timer = node.create_timer(
            PERIOD_SEC, self._decide, callback_group=MutuallyExclusiveCallbackGroup()
        )

    def _decide(self) -> None:
        if self._mode == 'false':
            self._finish('off')
        elif self._mode == 'auto' and self._scenes.is_ready:
            self._finish('off: another perception node was found')
        elif self._mode == 'true' or self._node.get_clock().now().nanoseconds >= self._end_ns:
            self._start()

    def _finish(self, message: str) -> None:
        self._timer.cancel()
        self._state = State(OK, message)

    def _start(self) -> None:
        self._finish('on: perception and metric run in this process')
        executor = self._node.executor
        try:
            for added in (
                PerceptionNode(cli_args=_named('perception_node')),
                MetricNode(self._host, cli_args=_named('metric_node')),
            ):
                executor.add_node(added)
        except SpatialRelationsError as error:
            self._node.report_bad('standalone', error)
            return
        self._node.get_logger().info(self._state.message)
