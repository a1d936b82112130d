"""The demonstration's side of the graph: listens to scenes, asks for imitations."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import PoseArray
from rclpy.node import Node
from spatial_relations_msgs.msg import Scene as SceneMsg
from spatial_relations_msgs.srv import GetScene, Imitate, ListRelations

from spatial_relations_ros.core import Scene, UnknownObjectError
from spatial_relations_ros.perception.messages import stamp_ns
from spatial_relations_ros.ros.conversions import scene_from_msg
from spatial_relations_ros.ros.qos import ANSWERS, SCENES
from spatial_relations_ros.ros.waiting import NoAnswerError, wait_for, wait_until


class DemoClient(Node):
    """A client of the three nodes; spun by a thread of its own."""

    def __init__(self) -> None:
        super().__init__('demo')
        self._lock = threading.Lock()
        self.scene_counts: Counter[tuple[str, str]] = Counter()
        self._latest_scene_ns = -1
        self._target_poses: list[PoseArray] = []
        self.create_subscription(SceneMsg, 'perception_node/scenes', self._on_scene, SCENES)
        self.create_subscription(PoseArray, 'target_poses', self._on_targets, ANSWERS)
        self._imitate = self.create_client(Imitate, 'imitate')
        self._get_scene = self.create_client(GetScene, 'perception_node/get_scene')
        self._list = self.create_client(ListRelations, 'metric_node/list')

    def _on_scene(self, msg: SceneMsg) -> None:
        with self._lock:
            self.scene_counts[msg.base.object_id, msg.relative.object_id] += 1
            self._latest_scene_ns = max(self._latest_scene_ns, stamp_ns(msg.header.stamp))

    def _on_targets(self, msg: PoseArray) -> None:
        with self._lock:
            self._target_poses.append(msg)

    def missing_services(self) -> list[str]:
        """Services of the three nodes that are not there yet."""
        clients = (self._imitate, self._get_scene, self._list)
        return [client.srv_name for client in clients if not client.service_is_ready()]

    def has_scene(self, object_ids: Sequence[str]) -> bool:
        """Whether a scene of base and relative has been received."""
        with self._lock:
            return bool(self.scene_counts[object_ids[0], object_ids[1]])

    def wait_for_scene_of(self, cloud_ns: int, timeout_sec: float) -> bool:
        """Waits for a scene of a cloud or a later one; False when none comes in time."""
        return wait_until(lambda: self._latest_scene_ns >= cloud_ns, timeout_sec)

    def scene(self, object_ids: Sequence[str], timeout_sec: float) -> Scene:
        """The scene of two objects as perception has it now.

        Raises:
            UnknownObjectError: when an object is not seen.
            NoAnswerError: when the node does not answer.
        """
        request = GetScene.Request(object_ids=list(object_ids))
        response = wait_for(self._get_scene.call_async(request), timeout_sec)
        if not response.success:
            raise UnknownObjectError(response.message)
        return scene_from_msg(response.scene)

    def imitate(
        self,
        reference_ids: Sequence[str],
        test_ids: Sequence[str],
        timeout_sec: float,
        *,
        time_budget_sec: float,
    ) -> Any:
        """Calls the service and returns its response.

        Args:
            reference_ids: base and relative of the demonstration.
            test_ids: base and relative to place.
            timeout_sec: longest wait for the answer.
            time_budget_sec: what the node may take to refine.

        Raises:
            NoAnswerError: when the node does not answer.
        """
        with self._lock:
            self._target_poses.clear()
        request = Imitate.Request(
            reference_ids=list(reference_ids),
            test_ids=list(test_ids),
            time_budget=time_budget_sec,
        )
        return wait_for(self._imitate.call_async(request), timeout_sec)

    def target_poses(self, timeout_sec: float) -> PoseArray:
        """The target poses of the last request.

        Raises:
            NoAnswerError: when none were published.
        """
        if not wait_until(lambda: bool(self._target_poses), timeout_sec):
            raise NoAnswerError(f'nothing on target_poses within {timeout_sec:g} s')
        with self._lock:
            return self._target_poses[-1]
