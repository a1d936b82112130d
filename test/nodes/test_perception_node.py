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
from manifold3d import Manifold
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import PointCloud2
from spatial_relations_msgs.msg import Scene as SceneMsg
from spatial_relations_msgs.msg import TrackedObject, TrackedObjectArray
from spatial_relations_msgs.srv import GetScene
from tf2_msgs.msg import TFMessage

from spatial_relations_ros.core import Pose, TriangleMesh
from spatial_relations_ros.datasets.kinect_simulator import (
    KinectSimulator,
    Surface,
    look_at,
    table_mesh,
)
from spatial_relations_ros.datasets.object_files import save_mesh
from spatial_relations_ros.nodes.perception_node import PerceptionNode
from spatial_relations_ros.perception.series import NS_PER_SEC
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.conversions import cloud_to_msg, header_to_msg, pose_to_msg
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


class Table:
    """Two boxes on a table before a simulated Kinect2, as a sensor and a tracker send them."""

    def __init__(self, folder: Path) -> None:
        sizes = {'box': (0.16, 0.12, 0.10), 'post': (0.06, 0.06, 0.20)}
        self.places = {'box': (0.0, 0.2, 0.05), 'post': (0.1, -0.2, 0.10)}
        camera_pose = look_at((-0.7, 0.0, 0.8), (0.05, 0.0, 0.0))
        surfaces = [Surface(table_mesh((0.8, 1.0)))]
        for object_id, size in sizes.items():
            solid = Manifold.cube(size, True).to_mesh()
            mesh = TriangleMesh(solid.vert_properties[:, :3], solid.tri_verts)
            save_mesh(folder / f'{object_id}.ply', mesh)
            surfaces.append(Surface(mesh.transformed(Pose(np.array(self.places[object_id])))))
        simulator = KinectSimulator(surfaces, camera_pose)
        self.xyz = simulator.xyz(simulator.measure(np.random.default_rng(0)))
        x, y, z = camera_pose.translation
        qw, qx, qy, qz = camera_pose.quat_wxyz
        self.camera_pose = f'{x} {y} {z} {qx} {qy} {qz} {qw}'
        self.stamp_ns = 1_700_000_000 * NS_PER_SEC

    def send(self, rig: Rig, shift: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
        """One cloud and its tracked poses, a tenth of a second after the last ones."""
        self.stamp_ns += NS_PER_SEC // 10
        message = TrackedObjectArray()
        for object_id, place in self.places.items():
            offset = np.array(shift) if object_id == 'post' else 0.0
            pose = pose_to_msg(Pose(np.array(place) + offset))
            header = header_to_msg(self.stamp_ns, 'world')
            message.objects.append(
                TrackedObject(header=header, object_id=object_id, pose=pose, confidence=1.0)
            )
        rig.tracks.publish(message)
        cloud = cloud_to_msg(self.xyz.reshape(-1, 3), header_to_msg(self.stamp_ns, 'camera'))
        cloud.height, cloud.width = self.xyz.shape[:2]
        cloud.row_step = cloud.width * cloud.point_step
        rig.clouds.publish(cloud)


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
