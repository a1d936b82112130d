"""Poses as vision_msgs/Detection3DArray over DDS; needs that package, which has no wheel."""

from __future__ import annotations

from pathlib import Path

import pytest
from ros_graph import Graph
from sensor_msgs.msg import PointCloud2
from simulated_table import PLACES, SimulatedTable
from spatial_relations_msgs.srv import GetScene

from spatial_relations_ros.perception.series import NS_PER_SEC
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.conversions import header_to_msg

vision_msgs = pytest.importorskip('vision_msgs.msg', reason='vision_msgs is not installed')

pytestmark = pytest.mark.ros

START_NS = 1_700_000_000 * NS_PER_SEC


def detections(stamp_ns: int) -> object:
    """Each box where it stands; a hypothesis that is less likely is somewhere else."""
    message = vision_msgs.Detection3DArray(header=header_to_msg(stamp_ns, 'world'))
    for object_id, (x, y, z) in PLACES.items():
        detection = vision_msgs.Detection3D(id=object_id)
        for score, shift in ((0.2, 0.3), (0.9, 0.0)):
            result = vision_msgs.ObjectHypothesisWithPose()
            result.hypothesis.class_id, result.hypothesis.score = 'thing', score
            position = result.pose.pose.position
            position.x, position.y, position.z = x + shift, y, z
            detection.results.append(result)
        message.detections.append(detection)
    return message


def test_objects_are_seen_where_they_were_detected(graph: Graph, tmp_path: Path) -> None:
    table = SimulatedTable(tmp_path, 200)
    graph.processes.start(
        'perception_node',
        parameters={
            'models_path': str(tmp_path),
            'camera_pose': table.camera_pose,
            'camera_frame': 'camera',
            'max_age': 0.0,
        },
    )
    clouds = graph.node.create_publisher(
        PointCloud2, '/perception_node/points', qos.latest_cloud(is_reliable=True)
    )
    tracks = graph.node.create_publisher(
        vision_msgs.Detection3DArray, '/perception_node/detections', qos.TRACKED_POSES
    )
    stamps = iter(range(START_NS, START_NS + 60 * NS_PER_SEC, NS_PER_SEC // 10))
    answers: list[GetScene.Response] = []

    def is_seen() -> bool:
        stamp_ns = next(stamps)
        tracks.publish(detections(stamp_ns))
        clouds.publish(table.cloud(stamp_ns))
        answers.append(
            graph.call(GetScene, '/perception_node/get_scene', object_ids=['box', 'post'])
        )
        return bool(answers[-1].success)

    graph.wait(is_seen, 'a scene')
    scene = answers[-1].scene
    for item in (scene.base, scene.relative):
        place = item.pose.position
        assert (place.x, place.y, place.z) == pytest.approx(PLACES[item.object_id], abs=0.02)
        assert item.support > 0.6
