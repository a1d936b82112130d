"""Core types to messages and back."""

from __future__ import annotations

import array
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import PointCloud2
from spatial_relations_msgs.msg import Scene as SceneMsg

from spatial_relations_ros.core import (
    CloudFormatError,
    CloudSource,
    InvalidPoseError,
    InvalidSceneError,
    Pose,
    Scene,
    SceneObject,
)
from spatial_relations_ros.perception.messages import read_pose, stamp_ns
from spatial_relations_ros.ros import conversions
from spatial_relations_ros.ros.conversions import (
    cloud_to_msg,
    header_to_msg,
    one_scene,
    pose_to_msg,
    scene_from_msg,
    scene_to_msg,
    stamp_to_msg,
)

numbers = st.floats(-100.0, 100.0)
quaternions = (
    st.tuples(*[st.floats(-1.0, 1.0)] * 4)
    .map(np.array)
    .filter(lambda quat: np.linalg.norm(quat) > 0.1)
    .map(lambda quat: quat / np.linalg.norm(quat))
)


def make_object(object_id: str, seed: int, **changes: object) -> SceneObject:
    rng = np.random.default_rng(seed)
    quat_wxyz = rng.normal(size=4)
    values: dict[str, object] = {
        'points': rng.normal(size=(20, 3)).astype(np.float32),
        'world_from_object': Pose(rng.normal(size=3), quat_wxyz / np.linalg.norm(quat_wxyz)),
    }
    return SceneObject(object_id, **{**values, **changes})  # type: ignore[arg-type]


def make_scene() -> Scene:
    base = make_object('plate', 1, support=0.75)
    relative = make_object('cup', 2, source=CloudSource.OBSERVED)
    return Scene(base, relative, stamp_ns=1_700_000_000_123_456_789, frame_id='map')


@given(translation=st.tuples(numbers, numbers, numbers), quat_wxyz=quaternions)
@settings(max_examples=60, deadline=None)
def test_poses_keep_their_meaning(translation: tuple[float, ...], quat_wxyz: np.ndarray) -> None:
    pose = Pose(np.array(translation), quat_wxyz)
    assert read_pose(pose_to_msg(pose)).is_close(pose)


def test_the_scalar_part_goes_last() -> None:
    half = math.sqrt(0.5)
    msg = pose_to_msg(Pose(np.zeros(3), np.array([half, 0.0, 0.0, half])))
    assert (msg.orientation.z, msg.orientation.w) == pytest.approx((half, half))
    assert msg.orientation.x == msg.orientation.y == 0.0


@given(st.integers(0, 2**31 * 1_000_000_000 - 1))
@settings(max_examples=50, deadline=None)
def test_stamps_keep_every_nanosecond(time_ns: int) -> None:
    assert stamp_ns(stamp_to_msg(time_ns)) == time_ns


def test_a_scene_survives_the_wire() -> None:
    scene = make_scene()
    wire = deserialize_message(serialize_message(scene_to_msg(scene)), SceneMsg)
    back = scene_from_msg(wire)
    assert back.object_ids == ('plate', 'cup')
    assert (back.stamp_ns, back.frame_id) == (scene.stamp_ns, 'map')
    for before, after in zip(scene.objects, back.objects, strict=True):
        np.testing.assert_array_equal(before.points, after.points)
        assert after.world_from_object.is_close(before.world_from_object)
        assert after.source == before.source
    assert back.base.support == 0.75
    assert math.isnan(back.relative.support)


def test_points_are_packed_float32() -> None:
    points = np.arange(12, dtype=np.float32).reshape(4, 3)
    msg = cloud_to_msg(points, header_to_msg(0, 'cup'))
    assert [(field.name, field.offset, field.datatype) for field in msg.fields] == [
        ('x', 0, 7), ('y', 4, 7), ('z', 8, 7),
    ]  # fmt: skip
    assert (msg.height, msg.width, msg.point_step, msg.row_step) == (1, 4, 12, 48)
    assert bytes(msg.data) == points.tobytes()


def test_clouds_are_filled_without_a_look_at_each_byte(monkeypatch: pytest.MonkeyPatch) -> None:
    """rclpy copies an array.array as a whole; numpy arrays and lists it takes byte by byte."""
    filled: list[object] = []

    def cloud(**fields: object) -> PointCloud2:
        filled.append(fields['data'])
        return PointCloud2(**fields)

    monkeypatch.setattr(conversions, 'PointCloud2', cloud)
    msg = cloud_to_msg(np.zeros((5, 3), dtype=np.float32), header_to_msg(0, 'cup'))
    assert isinstance(filled[0], array.array)
    assert len(msg.data) == 60


def test_a_pose_that_nobody_filled_is_refused() -> None:
    msg = scene_to_msg(make_scene())
    msg.base.pose.orientation.w = msg.base.pose.orientation.x = 0.0
    msg.base.pose.orientation.y = msg.base.pose.orientation.z = 0.0
    with pytest.raises(InvalidPoseError, match='unit quaternion'):
        scene_from_msg(msg)


def test_an_unknown_source_is_refused() -> None:
    msg = scene_to_msg(make_scene())
    msg.relative.source = 7
    with pytest.raises(InvalidSceneError, match='cup: source is 7'):
        scene_from_msg(msg)


def test_an_unreadable_cloud_is_refused() -> None:
    msg = scene_to_msg(make_scene())
    msg.base.cloud.row_step = 3
    with pytest.raises(CloudFormatError, match='row_step'):
        scene_from_msg(msg)


def test_a_request_holds_at_most_one_scene() -> None:
    msg = scene_to_msg(make_scene())
    assert one_scene([], 'test_scene', world_frame='map') is None
    scene = one_scene([msg], 'test_scene', world_frame='map')
    assert scene is not None
    assert scene.object_ids == ('plate', 'cup')
    with pytest.raises(InvalidSceneError, match='test_scene has 2 scenes'):
        one_scene([msg, msg], 'test_scene', world_frame='map')


def test_a_scene_in_another_frame_than_the_world_is_refused() -> None:
    msg = scene_to_msg(make_scene())
    with pytest.raises(InvalidSceneError, match=r"test: .*'map'.*'world'"):
        one_scene([msg], 'test', world_frame='world')
    for frame_id in ('', 'table', '/table'):
        msg.header.frame_id = frame_id
        scene = one_scene([msg], 'test', world_frame='table')
        assert scene is not None
        assert scene.frame_id == 'table'
