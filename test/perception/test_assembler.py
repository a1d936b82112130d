"""What arrives between two clouds."""

import numpy as np

from spatial_relations_ros.core import Pose
from spatial_relations_ros.perception.assembler import MAX_WAITING, FrameAssembler
from spatial_relations_ros.perception.border import StampedTransform, TrackedPose, TrackFault
from spatial_relations_ros.perception.point_cloud2 import PointCloud

CLOUD = PointCloud(np.zeros((2, 2, 3), dtype=np.float32))


def track(stamp_ns):
    return TrackedPose('cup', stamp_ns, 'camera', Pose())


def test_each_message_goes_with_the_next_cloud_and_no_other():
    assembler = FrameAssembler()
    transform = StampedTransform('world', 'camera', 0, Pose(), is_static=True)
    assembler.add_tracks([track(1), track(2)], [TrackFault('mug', 'no rotation')])
    assembler.add_transforms([transform])
    first = assembler.frame(3, 'camera', CLOUD)
    assembler.add_tracks([track(4)])
    second = assembler.frame(5, 'camera', CLOUD)
    assert [item.stamp_ns for item in first.tracks] == [1, 2]
    assert first.transforms == (transform,)
    assert first.faults[0].object_id == 'mug'
    assert [item.stamp_ns for item in second.tracks] == [4]
    assert second.transforms == second.faults == ()


def test_without_clouds_the_oldest_is_dropped():
    assembler = FrameAssembler()
    assembler.add_tracks(track(stamp) for stamp in range(MAX_WAITING + 3))
    frame = assembler.frame(0, 'camera', CLOUD)
    assert len(frame.tracks) == MAX_WAITING
    assert frame.tracks[0].stamp_ns == 3
