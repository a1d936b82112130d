"""Jumps of tracked poses, and ids that change places."""

import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError, Pose
from spatial_relations_ros.perception.border import TrackedPose
from spatial_relations_ros.perception.jumps import JumpConfig, JumpDetector

SEC = 1_000_000_000
LEFT, RIGHT = (0.0, 0.0, 1.0), (0.4, 0.0, 1.0)


def track(object_id, stamp_sec, place, frame_id='camera'):
    return TrackedPose(object_id, round(stamp_sec * SEC), frame_id, Pose(np.array(place)))


def jumps(*tracks, **config):
    detector = JumpDetector(JumpConfig(**config), max_gap_sec=0.5)
    for item in tracks:
        detector.add(item)
    return detector.take()


def test_motion_at_the_speed_of_a_hand_is_no_jump():
    tracks = [track('cup', 0.03 * k, (0.05 * k, 0, 1)) for k in range(20)]
    assert jumps(*tracks) == []


def test_a_jump_is_named_with_its_distance_and_time():
    (jump,) = jumps(track('cup', 0.0, LEFT), track('cup', 0.03, RIGHT))
    assert jump.object_id == 'cup'
    assert jump.reason == 'the tracked pose jumped by 0.40 m in 0.03 s'
    assert jump.rival_id is None


def test_jitter_is_no_jump_however_short_the_time():
    assert jumps(track('cup', 0.0, LEFT), track('cup', 1e-6, (0.04, 0, 1))) == []


def test_a_move_over_a_silence_is_no_jump():
    assert jumps(track('cup', 0.0, LEFT), track('cup', 0.6, (5, 0, 1))) == []


def test_poses_of_two_trackers_are_not_compared():
    tracks = [track('cup', 0.0, LEFT, 'ir'), track('cup', 0.01, RIGHT, 'rgb')]
    tracks += [track('cup', 0.03, LEFT, 'ir'), track('cup', 0.04, RIGHT, 'rgb')]
    assert jumps(*tracks) == []


def test_a_pose_that_comes_late_is_passed_over():
    tracks = [track('cup', 0.1, LEFT), track('cup', 0.05, RIGHT), track('cup', 0.13, LEFT)]
    assert jumps(*tracks) == []


def test_a_stamp_from_far_in_the_future_does_not_blind_the_detector():
    tracks = [track('cup', 1e6, LEFT), track('cup', 0.0, LEFT), track('cup', 0.03, RIGHT)]
    assert len(jumps(*tracks)) == 1


@pytest.mark.parametrize('interval_sec', [0.03, 0.2])
def test_two_that_change_places_name_each_other_at_any_rate(interval_sec):
    tracks = [track('cup', 0.0, LEFT), track('can', 0.0, RIGHT)]
    tracks += [track('cup', interval_sec, RIGHT), track('can', interval_sec, LEFT)]
    swaps = [jump for jump in jumps(*tracks) if jump.rival_id]
    assert {(swap.object_id, swap.rival_id) for swap in swaps} == {('cup', 'can'), ('can', 'cup')}
    assert 'may have swapped their ids' in swaps[0].reason
    assert {swap.settle_sec for swap in swaps} == {JumpConfig().swap_settle_sec}


def test_a_swap_is_seen_although_a_cloud_comes_in_between():
    detector = JumpDetector(JumpConfig(), max_gap_sec=0.5)
    for item in (track('cup', 0, LEFT), track('can', 0, RIGHT), track('cup', 0.03, RIGHT)):
        detector.add(item)
    assert [jump.rival_id for jump in detector.take()] == [None]
    detector.add(track('can', 0.03, LEFT))
    assert {jump.rival_id for jump in detector.take()} == {None, 'cup', 'can'}
    assert detector.take() == []


def test_moves_to_other_places_are_no_swap():
    tracks = [track('cup', 0.0, LEFT), track('can', 0.0, RIGHT)]
    tracks += [track('cup', 0.2, RIGHT), track('can', 0.2, (0.6, 0.0, 1.0))]
    assert jumps(*tracks) == []


def test_absurd_places_do_not_raise():
    (jump,) = jumps(track('cup', 0.0, LEFT), track('cup', 0.03, (1e200, 0, 0)))
    assert jump.object_id == 'cup'


def test_what_is_remembered_is_bounded_and_can_be_forgotten():
    detector = JumpDetector(JumpConfig(), max_gap_sec=0.5)
    for idx in range(2000):
        detector.add(track(f'cup_{idx}', 0.0, LEFT))
        detector.add(track(f'cup_{idx}', 0.01, RIGHT))
    assert len(detector.take()) <= 256
    detector.clear()
    detector.add(track('cup_1999', 0.02, LEFT))
    assert detector.take() == []


def test_refuses_impossible_settings():
    with pytest.raises(ConfigError):
        JumpConfig(max_speed=-1.0)
