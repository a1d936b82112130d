"""Notices other nodes of the same name."""

from __future__ import annotations

from rclpy.node import Node

from spatial_relations_ros.ros.diagnostics import OK, WARN, State


class SameName:
    """Counts the nodes of the graph that have a node's full name.

    ROS lets several run: requests then go to all of them, the first answer counts, and each
    publishes its own scenes and targets.

    Args:
        node: whose name it is.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._num_seen = 1

    def state(self) -> State:
        """For diagnostics; what is new is logged too."""
        node = self._node
        own = node.get_name(), node.get_namespace()
        num_seen = max(1, node.get_node_names_and_namespaces().count(own))
        is_new, self._num_seen = num_seen != self._num_seen, num_seen
        full_name = node.get_fully_qualified_name()
        if num_seen == 1:
            if is_new:
                node.get_logger().info(f'the only node named {full_name} again')
            return State(OK, 'the only one', {'nodes': 1})
        words = (
            f'{num_seen} nodes are named {full_name}: services are answered by any of them and '
            'topics are published twice; end the others or rename them with -r __node:=NAME. '
            'A node that was killed counts for up to 20 s.'
        )
        if is_new:
            node.get_logger().warning(words)
        return State(WARN, words, {'nodes': num_seen})
