"""Clouds that are malformed or unusual."""

from __future__ import annotations

import array
import math
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from demo_session import DemoSession
from sensor_msgs.msg import PointCloud2
from spatial_relations_msgs.srv import GetScene

from spatial_relations_ros.perception.messages import stamp_ns
from spatial_relations_ros.ros.conversions import header_to_msg

pytestmark = pytest.mark.ros

Breakage = Callable[[PointCloud2], None]


@pytest.fixture(autouse=True)
def _last_cloud_again(session: DemoSession) -> Iterator[None]:
    """The other files of this folder ask for scenes of the bag's last cloud."""
    yield
    session.show_again()


def _copy(cloud: PointCloud2) -> PointCloud2:
    return PointCloud2(
        header=cloud.header,
        height=cloud.height,
        width=cloud.width,
        fields=cloud.fields,
        is_bigendian=cloud.is_bigendian,
        point_step=cloud.point_step,
        row_step=cloud.row_step,
        data=cloud.data,
        is_dense=cloud.is_dense,
    )


def _wrong_row_step(cloud: PointCloud2) -> None:
    cloud.row_step = cloud.width * cloud.point_step - 1


def _no_point_step(cloud: PointCloud2) -> None:
    cloud.point_step = 0


def _all_nan(cloud: PointCloud2) -> None:
    values = np.frombuffer(cloud.data, dtype=np.float32)
    cloud.data = array.array('B', np.full_like(values, math.nan).tobytes())


def _too_short(cloud: PointCloud2) -> None:
    cloud.data = cloud.data[:1000]


def _no_frame(cloud: PointCloud2) -> None:
    cloud.header = type(cloud.header)(stamp=cloud.header.stamp)


def _unknown_frame(cloud: PointCloud2) -> None:
    cloud.header = type(cloud.header)(stamp=cloud.header.stamp, frame_id='nowhere')


def _big_endian(cloud: PointCloud2) -> None:
    """All fields of the Kinect2's clouds have four bytes."""
    words = np.frombuffer(cloud.data, dtype='<u4')
    cloud.data = array.array('B', words.astype('>u4').tobytes())
    cloud.is_bigendian = True


@pytest.mark.parametrize(
    ('breakage', 'word'),
    [
        (_wrong_row_step, 'row_step'),
        (_no_point_step, 'point_step is 0'),
        (_too_short, 'data has 1000 bytes'),
        (_no_frame, 'without a frame_id'),
        (_unknown_frame, 'nowhere'),
        (_all_nan, 'no finite points'),
    ],
)
def test_a_malformed_cloud_is_reported_and_survived(
    session: DemoSession, breakage: Breakage, word: str
) -> None:
    assert session.last_cloud is not None
    cloud = _copy(session.last_cloud)
    breakage(cloud)
    session.cloud_publisher.publish(cloud)

    def is_reported() -> bool:
        values = session.graph.diagnostic('perception_node: ~/points')
        return word in values.get('last_bad_reason', '') and word in values['message']

    session.graph.wait(is_reported, f'a diagnosis with {word!r}')
    assert session.graph.diagnostic('perception_node: ~/points')['level'] == '1'
    response = session.call(
        GetScene, '/perception_node/get_scene', object_ids=session.reference_ids
    )
    # Unreadable clouds change nothing; one without points or place has no objects.
    is_unusable = breakage in (_all_nan, _unknown_frame)
    assert response.success != is_unusable
    assert (word in response.message) == is_unusable


def test_a_big_endian_cloud_is_read(session: DemoSession) -> None:
    """It has a stamp of its own: no other cloud can give its scene."""
    assert session.last_cloud is not None
    cloud = _copy(session.last_cloud)
    _big_endian(cloud)
    stamp = header_to_msg(stamp_ns(cloud.header.stamp) + 1, '').stamp
    cloud.header = type(cloud.header)(stamp=stamp, frame_id=cloud.header.frame_id)

    def is_seen() -> bool:
        session.cloud_publisher.publish(cloud)
        ids = session.reference_ids
        found = session.call(GetScene, '/perception_node/get_scene', object_ids=ids)
        return found.success and found.scene.header.stamp == stamp

    session.graph.wait(is_seen, 'a scene of the big-endian cloud')
