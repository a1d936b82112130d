"""Poses and transforms out of messages, with the types of the bag reader."""

import numpy as np
import pytest

from spatial_relations_ros.core import InvalidPoseError, Pose
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.evaluation.bag_types import package_typestore
from spatial_relations_ros.perception.messages import (
    read_detections,
    read_pose,
    read_pose_stamped,
    read_tracked_objects,
    read_transforms,
    stamp_ns,
)

TYPES = package_typestore().types


def make(name, **fields):
    return TYPES[f'{name.split("/")[0]}/msg/{name.split("/")[1]}'](**fields)


def header(frame_id='camera', sec=12, nanosec=345):
    stamp = make('builtin_interfaces/Time', sec=sec, nanosec=nanosec)
    return make('std_msgs/Header', stamp=stamp, frame_id=frame_id)


def pose_message(xyz=(1.0, 2.0, 3.0), quat_xyzw=(0.0, 0.0, 0.0, 1.0)):
    position = make('geometry_msgs/Point', **dict(zip('xyz', xyz, strict=True)))
    orientation = make('geometry_msgs/Quaternion', **dict(zip('xyzw', quat_xyzw, strict=True)))
    return make('geometry_msgs/Pose', position=position, orientation=orientation)


def tracked(object_id='cup', frame_id='', confidence=0.9, **pose):
    return make(
        'spatial_relations_msgs/TrackedObject',
        header=header(frame_id, sec=13),
        object_id=object_id,
        pose=pose_message(**pose),
        confidence=confidence,
    )


def test_the_scalar_of_a_quaternion_moves_to_the_front():
    half = np.sqrt(0.5)
    expected = Pose.from_rotation(matrix_from_rotvec(np.array([np.pi / 2, 0, 0])), (1, 2, 3))
    assert read_pose(pose_message(quat_xyzw=(half, 0.0, 0.0, half))).is_close(expected)


@pytest.mark.parametrize(
    'pose', [{'xyz': (np.nan, 0.0, 0.0)}, {'quat_xyzw': (0.0, 0.0, 0.0, 0.0)}]
)
def test_poses_that_are_none_are_refused(pose):
    with pytest.raises(InvalidPoseError):
        read_pose(pose_message(**pose))
    message = make('geometry_msgs/PoseStamped', header=header(), pose=pose_message(**pose))
    tracks, faults = read_pose_stamped(message, 'cup')
    assert tracks == []
    assert faults[0].object_id == 'cup'
    assert 'tracked pose refused' in faults[0].reason


def test_stamps_are_whole_nanoseconds():
    assert stamp_ns(header(sec=1_700_000_000, nanosec=999_999_999).stamp) == 1700000000999999999


def test_an_array_lends_its_header_to_objects_without_one():
    message = make(
        'spatial_relations_msgs/TrackedObjectArray',
        header=header('camera', sec=12),
        objects=[
            tracked('cup'),
            tracked('mug', frame_id='hand'),
            tracked('', confidence=0.5),
            tracked('bad', quat_xyzw=(0.0, 0.0, 0.0, 2.0)),
            tracked('odd', confidence=float('nan')),
        ],
    )
    tracks, faults = read_tracked_objects(message)
    assert [(t.object_id, t.frame_id, t.stamp_ns) for t in tracks] == [
        ('cup', 'camera', 12_000_000_345),
        ('mug', 'hand', 13_000_000_345),
    ]
    assert tracks[0].confidence == pytest.approx(0.9)
    assert [fault.object_id for fault in faults] == ['', 'bad', 'odd']


def test_the_best_hypothesis_of_a_detection_counts():
    class Anything:
        def __init__(self, **fields):
            self.__dict__.update(fields)

    def result(class_id, score, x):
        return Anything(
            hypothesis=Anything(class_id=class_id, score=score),
            pose=Anything(pose=pose_message(xyz=(x, 0.0, 0.0))),
        )

    message = Anything(
        header=header('camera'),
        detections=[
            Anything(
                header=header(''),
                id='',
                results=[result('can', 0.2, 1.0), result('cup', 0.8, 2.0)],
            ),
            Anything(header=header('rgb'), id='mug_2', results=[result('mug', 0.5, 3.0)]),
            Anything(header=header(''), id='empty', results=[]),
        ],
    )
    tracks, faults = read_detections(message)
    assert faults == []
    assert [(t.object_id, t.frame_id) for t in tracks] == [('cup', 'camera'), ('mug_2', 'rgb')]
    assert tracks[0].frame_from_object.translation[0] == 2.0
    assert tracks[0].confidence == 0.8


def test_transforms_are_read_and_bad_ones_named():
    def transform(child, quat_xyzw=(0.0, 0.0, 0.0, 1.0)):
        translation = make('geometry_msgs/Vector3', x=1.0, y=2.0, z=3.0)
        rotation = make('geometry_msgs/Quaternion', **dict(zip('xyzw', quat_xyzw, strict=True)))
        return make(
            'geometry_msgs/TransformStamped',
            header=header('world'),
            child_frame_id=child,
            transform=make('geometry_msgs/Transform', translation=translation, rotation=rotation),
        )

    message = make(
        'tf2_msgs/TFMessage',
        transforms=[transform('camera'), transform('broken', (0.0, np.inf, 0.0, 0.0))],
    )
    transforms, faults = read_transforms(message, is_static=True)
    assert [(t.parent_frame, t.child_frame, t.is_static) for t in transforms] == [
        ('world', 'camera', True)
    ]
    np.testing.assert_array_equal(transforms[0].parent_from_child.translation, [1, 2, 3])
    assert faults[0].object_id == 'broken'
