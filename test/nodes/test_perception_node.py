"""perception_node in this process: bad items in messages, and trackers that lose objects."""

from __future__ import annotations

import threading
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import PointCloud2
from simulated_table import PLACES, SimulatedTable
from spatial_relations_msgs.msg import Scene as SceneMsg
from spatial_relations_msgs.msg import TrackedObjectArray
from spatial_relations_msgs.srv import GetScene
from tf2_msgs.msg import TFMessage

from spatial_relations_ros.nodes.perception_node import PerceptionNode
from spatial_relations_ros.perception.series import NS_PER_SEC
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.conversions import cloud_to_msg, header_to_msg
from spatial_relations_ros.ros.domains import free_domain_id
from spatial_relations_ros.ros.waiting import wait_for, wait_until

pytestmark = pytest.mark.ros

WAIT_SEC = 60.0


def transform(parent: str, child: str) -> TransformStamped:
    msg = TransformStamped(header=header_to_msg(0, parent), child_frame_id=child)
    msg.transform.rotation.w = 1.0
    return msg


class Rig:
    """A perception node, and another one that feeds and asks it, on a domain of their own."""

    def __init__(self, **parameters: Any) -> None:
        self.context = Context()
        rclpy.init(args=[], context=self.context, domain_id=free_domain_id())
        self.executor = MultiThreadedExecutor(6, context=self.context)
        overrides = [Parameter(name, value=value) for name, value in parameters.items()]
        self.node = PerceptionNode(context=self.context, parameter_overrides=overrides)
        self.other = Node('other', context=self.context)
        self.executor.add_node(self.node)
        self.executor.add_node(self.other)
        self.thread = threading.Thread(target=self._spin)
        self.thread.start()
        self.transforms = self.other.create_publisher(
            TFMessage, '/tf_static', qos.STATIC_TRANSFORMS
        )
        self.clouds = self.other.create_publisher(
            PointCloud2, '/perception_node/points', qos.latest_cloud(is_reliable=False)
        )
        self.tracks = self.other.create_publisher(
            TrackedObjectArray, '/perception_node/tracked_objects', qos.TRACKED_POSES
        )
        self.client = self.other.create_client(GetScene, '/perception_node/get_scene')
        self.scenes: list[SceneMsg] = []
        self.states: dict[str, str] = {}
        self.other.create_subscription(
            SceneMsg, '/perception_node/scenes', self.scenes.append, qos.SCENES
        )
        self.other.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)

    def _spin(self) -> None:
        with suppress(ExternalShutdownException):
            self.executor.spin()

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == 'perception_node: objects':
                self.states = {item.key: item.value for item in status.values}

    def ask(self, *object_ids: str) -> GetScene.Response:
        request = GetScene.Request(object_ids=list(object_ids))
        return wait_for(self.client.call_async(request), WAIT_SEC)

    def close(self) -> None:
        self.executor.shutdown()
        self.thread.join()
        self.node.destroy_node()
        self.other.destroy_node()
        rclpy.shutdown(context=self.context)


def test_a_bad_static_transform_does_not_lose_the_others() -> None:
    rig = Rig()
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (500, 3)).astype(np.float32)
    answers: list[str] = []

    def answer() -> str:
        rig.clouds.publish(cloud_to_msg(points, header_to_msg(1, 'camera')))
        answers.append(rig.ask('plate', 'cup').message)
        return answers[-1]

    try:
        assert wait_until(rig.client.service_is_ready, WAIT_SEC)
        assert wait_until(lambda: 'no transform' in answer(), WAIT_SEC), answers[-1]
        items = [transform('a', 'a'), transform('', 'b'), transform('world', 'camera')]
        rig.transforms.publish(TFMessage(transforms=items))
        assert wait_until(lambda: 'no transform' not in answer(), WAIT_SEC), answers[-1]
        assert 'known objects' in answers[-1]
    finally:
        rig.close()


class Table(SimulatedTable):
    """Sends itself, a tenth of a second after the last time."""

    stamp_ns = 1_700_000_000 * NS_PER_SEC

    def send(self, rig: Rig, shift: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
        self.stamp_ns += NS_PER_SEC // 10
        moved = np.array(PLACES['post']) + shift
        rig.tracks.publish(self.tracks(self.stamp_ns, {'post': moved.tolist()}))
        rig.clouds.publish(self.cloud(self.stamp_ns))


def test_a_tracker_that_loses_its_object_is_refused_with_the_reason(tmp_path: Path) -> None:
    table = Table(tmp_path)
    rig = Rig(
        models_path=str(tmp_path),
        camera_pose=table.camera_pose,
        camera_frame='camera',
        publish_rate=100.0,
    )
    last: list[GetScene.Response] = []

    def answer(*shift: float) -> GetScene.Response:
        table.send(rig, shift or (0.0, 0.0, 0.0))
        last.append(rig.ask('box', 'post'))
        return last[-1]

    lost = (-0.15, 0.1, 0.05)
    try:
        assert wait_until(rig.client.service_is_ready, WAIT_SEC)
        assert wait_until(lambda: answer().success and len(rig.scenes) > 0, WAIT_SEC), last[-1]
        assert last[-1].scene.relative.support > 0.8
        assert wait_until(lambda: 'no support' in answer(*lost).message, WAIT_SEC), last[-1]
        assert not last[-1].success
        assert last[-1].message.startswith('post: tracked pose has no support in the cloud (')
        assert 's ago; known objects: box' in last[-1].message

        def is_told() -> bool:
            answer(*lost)
            return rig.states.get('post', '').startswith('LOST: tracked pose has no support')

        assert wait_until(is_told, WAIT_SEC), rig.states
        assert rig.states['box'].startswith('TRACKED: MODEL, support ')
        num_scenes = len(rig.scenes)
        for _ in range(5):
            assert not answer(*lost).success
        assert len(rig.scenes) == num_scenes
        assert wait_until(lambda: answer().success, WAIT_SEC), last[-1]
    finally:
        rig.close()
