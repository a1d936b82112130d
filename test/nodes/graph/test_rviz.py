"""What RViz gets: markers of an imitation, and a configuration that shows what is published."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
import yaml
from demo_session import DemoSession
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from visualization_msgs.msg import Marker, MarkerArray

from spatial_relations_ros.core import share_path
from spatial_relations_ros.perception.messages import read_pose
from spatial_relations_ros.ros.marker_pictures import draw_markers
from spatial_relations_ros.ros.qos import ANSWERS

pytestmark = pytest.mark.ros

TYPES = {
    'rviz_default_plugins/MarkerArray': 'visualization_msgs/msg/MarkerArray',
    'rviz_default_plugins/PoseArray': 'geometry_msgs/msg/PoseArray',
    'rviz_default_plugins/PointCloud2': 'sensor_msgs/msg/PointCloud2',
}


@pytest.fixture(scope='module')
def imitation(session: DemoSession) -> tuple[object, list[Marker]]:
    """An answer with the markers that were published of it."""
    arrays: list[MarkerArray] = []
    session.graph.subscribe(MarkerArray, '/imitate_node/markers', arrays.append, ANSWERS)
    response = session.imitate()
    target = read_pose(response.answers[0].targets[1].target.pose)

    def is_there() -> bool:
        return bool(arrays) and any(
            marker.ns == 'targets' and read_pose(marker.pose).is_close(target)
            for marker in arrays[-1].markers
        )

    session.graph.wait(is_there, 'markers of the answer')
    return response.answers[0], arrays[-1].markers


def test_markers_show_the_demonstration_the_objects_and_the_way_to_the_target(
    imitation: tuple[object, list[Marker]], session: DemoSession
) -> None:
    answer, markers = imitation
    assert [marker.action for marker in markers].count(Marker.DELETEALL) == 1
    assert markers[0].action == Marker.DELETEALL, 'RViz deletes what came before it too'
    counts = Counter(marker.ns for marker in markers[1:])
    assert counts['reference'] == counts['test'] == 2
    assert counts['targets'] == counts['approach'] == 1, 'one object moves'
    assert counts['names'] == 4
    by_name = {marker.ns: marker for marker in markers}
    ghost, arrow = by_name['targets'], by_name['approach']
    assert ghost.type == Marker.TRIANGLE_LIST
    assert 0.0 < ghost.color.a < 1.0
    target = answer.targets[1]
    assert read_pose(ghost.pose).is_close(read_pose(target.target.pose))
    ends = np.array([[point.x, point.y, point.z] for point in arrow.points])
    np.testing.assert_allclose(ends[1], read_pose(target.target.pose).translation)
    np.testing.assert_allclose(ends[0], read_pose(target.approach.pose).translation)
    texts = [marker.text for marker in markers if marker.text]
    assert {*session.test_ids} <= {*texts}
    assert any(text.startswith(f'distance {answer.distance:.2f}, ') for text in texts)
    assert {marker.header.frame_id for marker in markers} == {session.plan.world_frame}


def test_a_picture_of_the_markers_shows_the_ghost(
    imitation: tuple[object, list[Marker]],
) -> None:
    _, markers = imitation
    picture = draw_markers(markers, width=240, height=160)
    without = draw_markers(
        [marker for marker in markers if marker.ns not in ('targets', 'text')], width=240,
        height=160,
    )  # fmt: skip
    assert picture.shape == (160, 240, 3)
    assert (picture != without).any(axis=-1).mean() > 0.005


def test_the_configuration_shows_topics_as_they_are_published(session: DemoSession) -> None:
    content = yaml.safe_load(share_path('config', 'relations.rviz').read_text())[
        'Visualization Manager'
    ]
    assert content['Global Options']['Fixed Frame'] == session.plan.world_frame
    shown = {
        display['Topic']['Value']: display
        for display in content['Displays']
        if 'Topic' in display and display['Class'] != 'rviz_default_plugins/PointCloud2'
    }
    assert set(shown) == {'/perception_node/markers', '/imitate_node/markers', '/target_poses'}
    published = dict(session.graph.node.get_topic_names_and_types())
    for topic, display in shown.items():
        assert published[topic] == [TYPES[display['Class']]]
        (publisher,) = session.graph.node.get_publishers_info_by_topic(topic)
        asked = display['Topic']
        # Asked for and not offered: RViz gets nothing. Offered and not asked for: nothing of what
        # was published before it started.
        latched = publisher.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        assert (asked['Durability Policy'] == 'Transient Local') == latched
        reliable = publisher.qos_profile.reliability == ReliabilityPolicy.RELIABLE
        assert reliable or asked['Reliability Policy'] == 'Best Effort'
