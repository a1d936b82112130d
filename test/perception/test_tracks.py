"""Which tracked poses are believed, and where they put the object."""

import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError, FrameTransformError, Pose
from spatial_relations_ros.perception.border import StampedTransform, TrackedPose
from spatial_relations_ros.perception.frames import TransformBuffer, TransformBufferConfig
from spatial_relations_ros.perception.tracks import TrackBuffer, TrackConfig, TrackRejectedError

SEC = 1_000_000_000


def track(seconds, x, *, frame='world', **changes):
    pose = Pose(np.array([x, 0.0, 0.0]))
    return TrackedPose('cup', round(seconds * SEC), frame, pose, **changes)


def x_at(buffer, seconds, transforms=None):
    transforms = transforms or TransformBuffer()
    pose = buffer.world_from_object('cup', round(seconds * SEC), transforms, 'world')
    return pose.translation[0]


def filled(*tracks, **config):
    buffer = TrackBuffer(TrackConfig(**config))
    for item in tracks:
        buffer.add(item)
    return buffer


def test_interpolates_between_two_poses_and_holds_the_last():
    buffer = filled(track(1.0, 0.0), track(1.2, 2.0))
    assert x_at(buffer, 1.05) == pytest.approx(0.5)
    assert x_at(buffer, 1.2) == 2.0
    assert x_at(buffer, 1.6) == 2.0


def test_does_not_bridge_long_gaps():
    buffer = filled(track(1.0, 0.0), track(3.0, 2.0), max_age_sec=0.5)
    assert x_at(buffer, 1.4) == 0.0
    with pytest.raises(TrackRejectedError, match=r'0.60 s old, at most 0.50 s'):
        x_at(buffer, 1.6)
    assert x_at(buffer, 2.96) == 2.0


def test_refuses_what_is_too_old_or_too_new():
    buffer = filled(track(1.0, 0.0))
    with pytest.raises(TrackRejectedError, match=r'the last tracked pose is 2.30 s old'):
        x_at(buffer, 3.3)
    with pytest.raises(TrackRejectedError, match=r'0.20 s later than the cloud'):
        x_at(buffer, 0.8)


def test_refuses_what_the_tracker_does_not_trust():
    buffer = filled(track(1.0, 0.0, confidence=0.1), min_confidence=0.3)
    with pytest.raises(TrackRejectedError, match=r'with 0.10 only, at least 0.30'):
        x_at(buffer, 1.0)


def test_each_pose_is_brought_to_the_world_at_its_own_time():
    transforms = TransformBuffer()
    for seconds in (1.0, 2.0):
        camera = Pose(np.array([10.0 * seconds, 0.0, 0.0]))
        transforms.add(StampedTransform('world', 'camera', round(seconds * SEC), camera))
    # The camera moves by 1 in 0.1 s and the object stands: it seems to move the other way.
    buffer = filled(track(1.0, 5.0, frame='camera'), track(1.1, 4.0, frame='camera'))
    assert x_at(buffer, 1.05, transforms) == pytest.approx(15.0)
    # Held: the place in the world at the time of the last pose, not carried on by the camera.
    assert x_at(buffer, 1.3, transforms) == pytest.approx(15.0)


def test_a_pose_is_held_for_longer_than_transforms_are_remembered():
    transforms = TransformBuffer(TransformBufferConfig(history_sec=2.0))
    buffer = filled(track(1.0, 5.0, frame='camera'), max_age_sec=30.0)
    for seconds in range(1, 21):
        camera = Pose(np.array([10.0 * seconds, 0.0, 0.0]))
        transforms.add(StampedTransform('world', 'camera', seconds * SEC, camera))
        assert x_at(buffer, seconds, transforms) == pytest.approx(15.0)
    buffer.clear()
    buffer.add(track(1.0, 5.0, frame='camera'))
    with pytest.raises(FrameTransformError, match='known from'):
        x_at(buffer, 20.0, transforms)


def test_an_unknown_frame_is_named():
    with pytest.raises(FrameTransformError, match="'nowhere'"):
        x_at(filled(track(1.0, 0.0, frame='nowhere')), 1.0)


def test_only_so_many_objects_are_remembered():
    buffer = TrackBuffer(TrackConfig(max_objects=2))
    for object_id in ('a', 'b', 'a', 'c'):
        buffer.add(TrackedPose(object_id, 0, 'world', Pose()))
    assert buffer.object_ids == ('a', 'c')


def test_a_clock_that_starts_again_is_followed():
    buffer = filled(track(100.0, 1.0), track(0.0, 2.0))
    assert x_at(buffer, 0.1) == 2.0


@pytest.mark.parametrize(
    'wrong',
    [{'max_age_sec': -1}, {'min_confidence': 2}, {'max_objects': 0}, {'history_sec': np.nan}],
)
def test_refuses_impossible_settings(wrong):
    with pytest.raises(ConfigError):
        TrackConfig(**wrong)
