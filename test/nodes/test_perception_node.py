"""perception_node in this process: what one bad item in a message does to the others."""

from __future__ import annotations

import threading
from contextlib import suppress

import numpy as np
import pytest
import rclpy
from geometry_msgs.msg import TransformStamped
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2
from spatial_relations_msgs.srv import GetScene
from tf2_msgs.msg import TFMessage

from spatial_relations_ros.nodes.perception_node import PerceptionNode
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


def test_a_bad_static_transform_does_not_lose_the_others() -> None:
    context = Context()
    rclpy.init(args=[], context=context, domain_id=free_domain_id())
    executor = MultiThreadedExecutor(6, context=context)
    node, other = PerceptionNode(context=context), Node('other', context=context)
    executor.add_node(node)
    executor.add_node(other)

    def spin() -> None:
        with suppress(ExternalShutdownException):
            executor.spin()

    thread = threading.Thread(target=spin)
    thread.start()
    transforms = other.create_publisher(TFMessage, '/tf_static', qos.STATIC_TRANSFORMS)
    clouds = other.create_publisher(
        PointCloud2, '/perception_node/points', qos.latest_cloud(is_reliable=False)
    )
    client = other.create_client(GetScene, '/perception_node/get_scene')
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (500, 3)).astype(np.float32)
    answers: list[str] = []

    def answer() -> str:
        clouds.publish(cloud_to_msg(points, header_to_msg(1, 'camera')))
        request = GetScene.Request(object_ids=['plate', 'cup'])
        answers.append(wait_for(client.call_async(request), WAIT_SEC).message)
        return answers[-1]

    try:
        assert wait_until(client.service_is_ready, WAIT_SEC)
        assert wait_until(lambda: 'no transform' in answer(), WAIT_SEC), answers[-1]
        items = [transform('a', 'a'), transform('', 'b'), transform('world', 'camera')]
        transforms.publish(TFMessage(transforms=items))
        assert wait_until(lambda: 'no transform' not in answer(), WAIT_SEC), answers[-1]
        assert 'known objects' in answers[-1]
    finally:
        executor.shutdown()
        thread.join()
        node.destroy_node()
        other.destroy_node()
        rclpy.shutdown(context=context)
