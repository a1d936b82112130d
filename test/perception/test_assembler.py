"""Clouds and the tracked poses of their time, in every order of arrival."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spatial_relations_ros.core import ConfigError, Pose
from spatial_relations_ros.perception.assembler import (
    JUMPED,
    MAX_WAITING,
    OVERRUN,
    AssemblyConfig,
    FrameAssembler,
)
from spatial_relations_ros.perception.border import StampedTransform, TrackedPose, TrackFault
from spatial_relations_ros.perception.point_cloud2 import PointCloud

CLOUD = PointCloud(np.zeros((2, 2, 3), dtype=np.float32))
MS = 1_000_000


def track(stamp_ms, object_id='cup'):
    return TrackedPose(object_id, stamp_ms * MS, 'camera', Pose())


class Line:
    """An assembler on a clock in milliseconds, and the frames that it gave."""

    def __init__(self, **config):
        self.assembler = FrameAssembler(AssemblyConfig(**config))
        self.frames = []

    def take(self, now_ms):
        now_ns = None if now_ms is None else now_ms * MS
        while (frame := self.assembler.take(now_ns)) is not None:
            self.frames.append(frame)
        return [frame.stamp_ns // MS for frame in self.frames]

    def cloud(self, stamp_ms, now_ms=None):
        now_ms = stamp_ms if now_ms is None else now_ms
        self.assembler.add_cloud(stamp_ms * MS, 'camera', CLOUD, now_ms * MS)
        return self.take(now_ms)

    def tracks(self, *stamps_ms, object_id='cup', now_ms=0):
        self.assembler.add_tracks([track(stamp, object_id) for stamp in stamps_ms])
        return self.take(now_ms)

    @property
    def contents(self):
        """(stamp of the cloud, [(object, stamp of its pose)]) of each frame."""
        return [
            (
                frame.stamp_ns // MS,
                sorted((item.object_id, item.stamp_ns // MS) for item in frame.tracks),
            )
            for frame in self.frames
        ]


def test_everything_goes_with_one_cloud_only():
    assembler = FrameAssembler()
    transform = StampedTransform('world', 'camera', 0, Pose(), is_static=True)
    assembler.add_tracks([track(1), track(2)], [TrackFault('mug', 'no rotation')])
    assembler.add_transforms([transform])
    assembler.add_cloud(2 * MS, 'camera', CLOUD, 0)
    first = assembler.take(0)
    assembler.add_tracks([track(4)])
    assembler.add_cloud(4 * MS, 'camera', CLOUD, 0)
    second = assembler.take(0)
    assert [item.stamp_ns // MS for item in first.tracks] == [1, 2]
    assert first.transforms == (transform,)
    assert first.faults[0].object_id == 'mug'
    assert [item.stamp_ns // MS for item in second.tracks] == [4]
    assert second.transforms == second.faults == ()
    assert assembler.take(None) is None


def test_a_cloud_whose_poses_are_there_does_not_wait():
    line = Line()
    line.tracks(100)
    assert line.cloud(100) == [100]


def test_the_first_cloud_of_unknown_objects_does_not_wait():
    assert Line().cloud(100) == [100]


def test_poses_that_come_after_their_cloud_go_with_it():
    line = Line()
    line.tracks(100), line.tracks(100, object_id='mug')
    line.cloud(100)
    assert line.cloud(200) == [100]
    assert line.tracks(190, 210, now_ms=220) == [100]
    assert line.tracks(199, object_id='mug', now_ms=230) == [100]
    assert line.tracks(200, object_id='mug', now_ms=240) == [100, 200]
    assert line.contents[1] == (200, [('cup', 190), ('cup', 210), ('mug', 199), ('mug', 200)])


def test_poses_that_never_come_hold_up_one_cloud_until_they_are_heard_of_again():
    line = Line()
    line.tracks(100), line.tracks(100, object_id='mug')
    assert line.cloud(133) == []
    assert line.tracks(133, now_ms=150) == []  # the mug's tracker has stopped
    assert line.take(232) == []
    assert line.take(233) == [133]
    line.tracks(166, now_ms=234)
    assert line.cloud(166, 240) == [133, 166]
    line.tracks(180, object_id='mug', now_ms=241), line.tracks(200, now_ms=242)
    assert line.cloud(200, 243) == [133, 166]
    assert line.tracks(200, object_id='mug', now_ms=244) == [133, 166, 200]


def test_without_a_wait_clouds_take_what_is_there():
    line = Line(pose_wait_sec=0.0)
    line.tracks(100)
    assert line.cloud(200) == [200]


def test_the_end_and_a_clock_that_is_set_back_end_the_wait():
    for now_ms in (None, 50):
        line = Line()
        line.tracks(100)
        assert line.cloud(200) == []
        assert line.take(now_ms) == [200]


def test_when_many_clouds_wait_the_first_waits_no_longer():
    line = Line(max_clouds=3)
    line.tracks(100)
    assert line.cloud(101) == line.cloud(102) == []
    assert line.cloud(103) == [101, 102, 103]
    assert not line.assembler.dropped


def test_when_nobody_takes_them_the_newest_cloud_wins():
    line = Line(max_clouds=3)
    line.tracks(100)
    for stamp in range(101, 105):
        line.assembler.add_cloud(stamp * MS, 'camera', CLOUD, 0)
    assert line.assembler.num_clouds == 1
    assert line.assembler.dropped == {OVERRUN: 3}
    line.tracks(101, 102, 103, 104)
    assert line.contents == [(104, [('cup', stamp) for stamp in range(100, 105)])]


def test_a_jump_back_gives_up_what_waits_and_starts_afresh():
    line = Line()
    line.tracks(9_000, 10_000)
    line.cloud(9_500, 0), line.cloud(10_030, 0)
    line.tracks(100, now_ms=1)  # its poses jump first
    assert line.cloud(100, 1) == [9_500, 100]
    assert line.assembler.dropped == {JUMPED: 1}
    assert line.contents[1] == (100, [('cup', 100)])
    assert line.cloud(133, 2) == [9_500, 100]
    assert line.tracks(133, now_ms=3) == [9_500, 100, 133]


def test_a_cloud_that_jumps_back_before_its_poses_waits_for_none_of_the_past():
    line = Line()
    line.tracks(10_000, 10_100)
    line.cloud(10_000, 0)
    assert line.cloud(100, 1) == [10_000, 100]
    assert line.contents[1] == (100, [])
    line.tracks(100, 133, now_ms=2)
    line.cloud(133, 3)
    assert line.contents[2] == (133, [('cup', 100), ('cup', 133)])


def test_a_jump_forward_waits_once():
    line = Line()
    line.tracks(100)
    line.cloud(100)
    assert line.cloud(3_600_000, 130) == [100]
    assert line.tracks(3_600_000, now_ms=140) == [100, 3_600_000]


def test_objects_that_are_frames_of_tf_are_waited_for():
    line = Line(object_frames=('cup',))

    def move(stamp_ms):
        transform = StampedTransform('world', '/cup', stamp_ms * MS, Pose())
        other = StampedTransform('world', 'wheel', 0, Pose())
        line.assembler.add_transforms([transform, other])
        return line.take(stamp_ms)

    move(100)
    assert line.cloud(133) == []
    assert move(133) == [133]


@given(st.data())
def test_frames_do_not_depend_on_the_order_in_which_topics_arrive(data):
    """Each topic keeps its order; between topics anything may happen within the wait."""
    clouds = [('cloud', stamp) for stamp in range(0, 400, 33)]
    cup = [('cup', stamp) for stamp in range(0, 433, data.draw(st.integers(7, 90)))]
    mug = [('mug', stamp) for stamp in range(5, 433, data.draw(st.integers(7, 90)))]
    cup.append(('cup', 450)), mug.append(('mug', 450))

    def frames(topics):
        line = Line(max_clouds=100)
        line.tracks(-1), line.tracks(-1, object_id='mug')
        topics = [list(topic) for topic in topics]
        while any(topics):
            kind, stamp = data.draw(st.sampled_from([item for item in topics if item])).pop(0)
            if kind == 'cloud':
                line.cloud(stamp, 0)
            else:
                line.tracks(stamp, object_id=kind)
        assert not line.assembler.dropped
        return line.contents

    first, second = frames([clouds, cup, mug]), frames([clouds, cup, mug])
    assert len(first) == len(clouds)
    assert first == second
    for (stamp, tracks), object_id in itertools.product(first[:1], ('cup', 'mug')):
        assert max(at for name, at in tracks if name == object_id) >= stamp


def test_without_clouds_the_oldest_pose_is_dropped():
    line = Line()
    line.tracks(*range(MAX_WAITING + 3))
    line.cloud(MAX_WAITING + 2)
    assert len(line.frames[0].tracks) == MAX_WAITING
    assert line.frames[0].tracks[0].stamp_ns == 3 * MS


def test_a_tracker_that_invents_ids_fills_no_memory_and_holds_up_no_cloud():
    line = Line()
    for idx in range(3 * MAX_WAITING):
        line.tracks(idx // 100, object_id=f'ghost_{idx}')
    line.cloud(200)
    assert line.take(300) == [200]
    assert len(line.frames[0].tracks) == MAX_WAITING


@pytest.mark.parametrize(
    'wrong', [{'pose_wait_sec': -0.1}, {'pose_wait_sec': float('nan')}, {'max_clouds': 0}]
)
def test_a_config_that_cannot_work_is_refused(wrong):
    with pytest.raises(ConfigError):
        AssemblyConfig(**wrong)
