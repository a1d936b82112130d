"""imitate_node alone: perception and metric in its own process."""

from __future__ import annotations

import time
from typing import Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup

from spatial_relations_ros.nodes.metric_node import MetricNode
from spatial_relations_ros.nodes.model_host import ModelHost
from spatial_relations_ros.nodes.perception_node import PerceptionNode
from spatial_relations_ros.nodes.scene_client import SceneClient
from spatial_relations_ros.ros.diagnostics import ERROR, OK, State
from spatial_relations_ros.ros.relations_node import RelationsNode
from spatial_relations_ros.ros.running import SpinThread, spin_alone
from spatial_relations_ros.ros.timers import steady_timer

PERIOD_SEC = 0.1


class Standalone:
    """Decides once, after start, whether perception and metric run in this process.

    A timer decides, not the constructor: finding other nodes takes time.
    """

    def __init__(self, node: RelationsNode, host: ModelHost, scenes: SceneClient) -> None:
        self._node, self._host, self._scenes = node, host, scenes
        self._mode = node.parameters.text('standalone')
        self._end_sec = time.monotonic() + node.parameters.number('discovery_time')
        self._state = State(OK, 'looking for a perception node')
        self._perception: SpinThread | None = None
        node.diagnostics.add_state('standalone', lambda: self._state)
        group = MutuallyExclusiveCallbackGroup()
        self._timer = steady_timer(node, PERIOD_SEC, self._decide, group=group)

    def close(self) -> None:
        """Ends the perception of this process; what else was started ends with its executor."""
        self._timer.cancel()
        if self._perception is not None:
            self._perception.close()
            self._perception = None

    def _decide(self) -> None:
        if self._mode == 'false':
            self._finish('off')
        elif self._mode == 'auto' and self._scenes.is_ready:
            self._finish('off: another perception node was found')
        elif self._mode == 'true' or time.monotonic() >= self._end_sec:
            self._start()

    def _finish(self, message: str) -> None:
        self._timer.cancel()
        self._state = State(OK, message)

    def _node_arguments(self, parameter: str) -> dict[str, Any]:
        """Gives a node the name under which it is asked, whatever ``-r __node:=`` the process got.

        Args:
            parameter: holds that name.
        """
        name = self._node.parameters.text(parameter)
        namespace, _, name = self._node.resolve_service_name(name).rpartition('/')
        arguments = ['--ros-args', '-r', f'__ns:={namespace or "/"}', '-r', f'__node:={name}']
        return {'cli_args': arguments, 'context': self._node.context}

    def _start(self) -> None:
        self._timer.cancel()
        made: list[RelationsNode] = []
        try:
            made.append(PerceptionNode(**self._node_arguments('perception')))
            made.append(MetricNode(self._host, **self._node_arguments('metric')))
        except Exception as error:  # from a timer it would end the node
            for node in made:
                node.destroy_node()
            reason = self._node.report_bad('standalone', error)
            self._state = State(ERROR, f'perception and metric do not run: {reason}')
            return
        perception, metric = made
        # Clouds come often: they must not share the executor of those who wait (see run_node).
        self._perception = spin_alone(perception)
        self._node.executor.add_node(metric)
        self._finish('on: perception and metric run in this process')
        self._node.get_logger().info(self._state.message)
