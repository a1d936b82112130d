"""Publishes what perception has made of a cloud: scenes and markers."""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence

from spatial_relations_msgs.msg import Scene as SceneMsg
from std_msgs.msg import Header
from visualization_msgs.msg import MarkerArray

from spatial_relations_ros.nodes.perception_parameters import ordered_pairs
from spatial_relations_ros.perception.border import FrameResult
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.conversions import header_to_msg, scene_object_to_msg
from spatial_relations_ros.ros.markers import object_markers
from spatial_relations_ros.ros.relations_node import RelationsNode

# Of the period: clouds come with jitter, and none shall be left out that is early by a little.
TOLERANCE = 0.25


class RateLimit:
    """Lets things through at most at a rate, on average."""

    def __init__(self) -> None:
        self._next_sec = 0.0

    def is_due(self, now_sec: float, rate: float) -> bool:
        """Whether one more may pass now; it is counted when so."""
        period_sec = 1.0 / rate
        if now_sec < self._next_sec - TOLERANCE * period_sec:
            return False
        self._next_sec = max(self._next_sec + period_sec, now_sec)
        return True


class ScenePublisher:
    """Publishes ``~/scenes`` and ``~/markers``, when someone listens, at ``publish_rate``."""

    def __init__(self, node: RelationsNode) -> None:
        self._node = node
        self._limit = RateLimit()
        self._scenes = node.create_publisher(SceneMsg, '~/scenes', qos.SCENES)
        self._markers = node.create_publisher(MarkerArray, '~/markers', qos.SCENES)

    def publish(self, result: FrameResult) -> None:
        """Publishes one result, unless the last one was a moment ago."""
        parameters = self._node.parameters
        if not self._limit.is_due(time.monotonic(), parameters.number('publish_rate')):
            return
        header = header_to_msg(result.stamp_ns, result.frame_id)
        if self._scenes.get_subscription_count():
            self._publish_scenes(result, header, ordered_pairs(parameters.texts('pairs')))
        if self._markers.get_subscription_count():
            objects = result.objects.values()
            self._markers.publish(object_markers(objects, header, namespace='objects'))

    def _publish_scenes(
        self, result: FrameResult, header: Header, wanted: Sequence[tuple[str, str]]
    ) -> None:
        pairs = [
            pair
            for pair in wanted or itertools.permutations(result.objects, 2)
            if pair[0] in result.objects and pair[1] in result.objects
        ]
        messages = {
            object_id: scene_object_to_msg(result.objects[object_id], header)
            for object_id in {object_id for pair in pairs for object_id in pair}
        }
        for base_id, relative_id in pairs:
            self._scenes.publish(
                SceneMsg(header=header, base=messages[base_id], relative=messages[relative_id])
            )
