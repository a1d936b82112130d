"""Chains of transforms over time."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spatial_relations_ros.core import ConfigError, FrameTransformError, Pose
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.perception.border import StampedTransform
from spatial_relations_ros.perception.frames import (
    MAX_FRAMES,
    TransformBuffer,
    TransformBufferConfig,
    interpolate_poses,
)

SEC = 1_000_000_000
START = 1_700_000_000 * SEC


def pose_of(rotvec, translation):
    return Pose.from_rotation(matrix_from_rotvec(np.array(rotvec, dtype=float)), translation)


def moving(seconds, translation, rotvec=(0, 0, 0), *, parent='world', child='base'):
    pose = pose_of(rotvec, translation)
    return StampedTransform(parent, child, START + round(seconds * SEC), pose)


def static(parent, child, pose):
    return StampedTransform(parent, child, 0, pose, is_static=True)


def test_chains_static_transforms_both_ways():
    world_from_link, link_from_camera = (
        pose_of((0.3, -0.2, 1.0), (1, 2, 3)),
        pose_of((-1.0, 0.5, 0.1), (0.1, 0, 0.2)),
    )
    buffer = TransformBuffer()
    buffer.add(static('/world', 'link', world_from_link))
    buffer.add(static('link', 'camera', link_from_camera))
    expected = world_from_link @ link_from_camera
    assert buffer.lookup('world', '/camera', START).is_close(expected)
    assert buffer.lookup('camera', 'world', 0).is_close(expected.inverse())
    assert buffer.lookup('anything', 'anything', 5).is_close(Pose.identity())


def test_interpolates_exactly_at_large_stamps():
    buffer = TransformBuffer()
    buffer.add(moving(0.0, (0, 0, 0)))
    buffer.add(moving(0.001, (1, 0, 0), (0, 0, 1.0)))
    # A float of this size holds nanoseconds in steps of 256 only.
    middle = buffer.lookup('world', 'base', START + 100)
    np.testing.assert_allclose(middle.translation, [1e-4, 0, 0], rtol=1e-9)
    quarter = buffer.lookup('world', 'base', START + 250_000)
    assert quarter.is_close(pose_of((0, 0, 0.25), (0.25, 0, 0)))


def test_a_moving_and_a_static_transform_chain_at_one_time():
    buffer = TransformBuffer()
    buffer.add(static('base', 'camera', pose_of((0, 0, np.pi / 2), (0, 0, 1))))
    buffer.add(moving(0.0, (0, 0, 0)))
    buffer.add(moving(1.0, (2, 0, 0)))
    at_half = buffer.lookup('world', 'camera', START + SEC // 2)
    assert at_half.is_close(pose_of((0, 0, np.pi / 2), (1, 0, 1)))


def test_extrapolates_only_as_far_as_allowed():
    buffer = TransformBuffer(TransformBufferConfig(max_extrapolation_sec=0.1))
    buffer.add(moving(1.0, (1, 0, 0)))
    buffer.add(moving(2.0, (2, 0, 0)))
    held = buffer.lookup('world', 'base', START + round(2.1 * SEC))
    np.testing.assert_array_equal(held.translation, [2, 0, 0])
    reason = r"'base' to 'world' at 1700000002.101 s: known from 1700000001.000 s"
    with pytest.raises(FrameTransformError, match=reason):
        buffer.lookup('world', 'base', START + round(2.101 * SEC))
    with pytest.raises(FrameTransformError, match='known from'):
        buffer.lookup('world', 'base', START + round(0.89 * SEC))


def test_a_new_sample_is_seen_although_the_time_was_asked_for_before():
    buffer = TransformBuffer()
    buffer.add(moving(0.0, (0, 0, 0)))
    assert buffer.lookup('world', 'base', START).translation[0] == 0
    buffer.add(moving(0.0, (5, 0, 0)))
    assert buffer.lookup('world', 'base', START).translation[0] == 5


def test_unknown_and_unconnected_frames_are_named():
    buffer = TransformBuffer()
    with pytest.raises(
        FrameTransformError, match="nothing is known of 'lost'; known frames: none"
    ):
        buffer.lookup('world', 'lost', 0)
    buffer.add(static('world', 'a', Pose()))
    buffer.add(static('island', 'b', Pose()))
    with pytest.raises(
        FrameTransformError, match=r'not connected; known: island -> b, world -> a'
    ):
        buffer.lookup('world', 'b', 0)


def test_time_that_jumps_back_forgets_the_future():
    buffer = TransformBuffer()
    buffer.add(moving(10.0, (10, 0, 0)))
    buffer.add(moving(0.0, (0, 0, 0)))
    assert buffer.lookup('world', 'base', START).translation[0] == 0
    with pytest.raises(FrameTransformError, match='known from'):
        buffer.lookup('world', 'base', START + 10 * SEC)


def test_forgetting_keeps_static_transforms_only():
    buffer = TransformBuffer()
    buffer.add(static('base', 'camera', Pose()))
    buffer.add(moving(0.0, (0, 0, 0)))
    buffer.forget_moving()
    assert buffer.lookup('base', 'camera', START).is_close(Pose())
    with pytest.raises(FrameTransformError, match='was forgotten when time jumped back'):
        buffer.lookup('world', 'camera', START)


def test_a_child_moves_to_its_new_parent():
    buffer = TransformBuffer()
    buffer.add(static('world', 'table', Pose(np.array([1.0, 0, 0]))))
    buffer.add(static('world', 'hand', Pose(np.array([0, 2.0, 0]))))
    buffer.add(static('table', 'cup', Pose(np.array([0, 0, 0.1]))))
    buffer.add(static('hand', 'cup', Pose(np.array([0, 0, 0.2]))))
    np.testing.assert_allclose(buffer.lookup('world', 'cup', 0).translation, [0, 2, 0.2])
    np.testing.assert_allclose(buffer.lookup('table', 'cup', 0).translation, [-1, 2, 0.2])


@pytest.mark.parametrize(('parent', 'child'), [('', 'a'), ('a', ''), ('a', '/a')])
def test_refuses_names_that_make_no_tree(parent, child):
    with pytest.raises(FrameTransformError, match='two different frames'):
        TransformBuffer().add(static(parent, child, Pose()))


def test_the_number_of_frames_is_bounded():
    buffer = TransformBuffer()
    for idx in range(MAX_FRAMES - 1):
        buffer.add(static('world', f'frame_{idx}', Pose()))
    with pytest.raises(FrameTransformError, match=f'{MAX_FRAMES} frames are known'):
        buffer.add(static('world', 'one_more', Pose()))
    buffer.add(static('world', 'frame_0', Pose(np.ones(3))))
    assert buffer.lookup('world', 'frame_0', 0).translation[0] == 1


angles = st.floats(-3, 3, allow_nan=False)


@settings(max_examples=50, deadline=None)
@given(st.tuples(angles, angles, angles), st.tuples(angles, angles, angles), st.floats(0, 1))
def test_interpolation_divides_the_way_and_the_angle(first, second, fraction):
    start, end = pose_of(first, first), pose_of(second, second)
    between = interpolate_poses(start, end, fraction)
    way = np.linalg.norm(end.translation - start.translation)
    passed = np.linalg.norm(between.translation - start.translation)
    assert passed == pytest.approx(fraction * way, abs=1e-9)
    whole, part = (
        2 * np.arccos(np.clip(abs(np.dot(start.quat_wxyz, pose.quat_wxyz)), 0, 1))
        for pose in (end, between)
    )
    assert part == pytest.approx(fraction * whole, abs=1e-6)


def test_refuses_negative_limits():
    with pytest.raises(ConfigError, match='must be positive'):
        TransformBufferConfig(history_sec=0)
    with pytest.raises(ConfigError, match='must not be negative'):
        TransformBufferConfig(max_extrapolation_sec=-1)
