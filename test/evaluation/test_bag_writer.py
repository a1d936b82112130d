"""What the recorder writes is what others read."""

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader, StoragePlugin
from rosbags.typesys import Stores, get_typestore

from spatial_relations_ros.core import BagError, Pose
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.evaluation.bag_writer import BagWriter
from spatial_relations_ros.perception.border import StampedTransform, TrackedPose
from spatial_relations_ros.perception.messages import read_pose, read_transforms, stamp_ns
from spatial_relations_ros.perception.point_cloud2 import read_xyz

STAMP_NS = 1_700_000_000_123_456_789
POSE = Pose.from_rotation(matrix_from_rotvec(np.array([0.3, -0.5, 0.8])), (1.0, -2.0, 3.0))


def test_a_cloud_is_laid_out_as_iai_kinect2_does(tmp_path):
    writer = BagWriter(tmp_path / 'bag')
    xyz = np.random.default_rng(0).random((3, 5, 3)).astype(np.float32)
    xyz[1, 2] = np.nan
    rgb = np.arange(45, dtype=np.uint8).reshape(3, 5, 3)
    message = writer.cloud(STAMP_NS, 'optical', xyz, rgb)
    assert (message.height, message.width, message.point_step, message.row_step) == (3, 5, 32, 160)
    assert {field.name: field.offset for field in message.fields} == {
        'x': 0, 'y': 4, 'z': 8, 'rgb': 16
    }  # fmt: skip
    assert not message.is_dense
    np.testing.assert_array_equal(read_xyz(message).xyz, xyz)
    packed = message.data.reshape(15, 32)[:, 16:20]
    np.testing.assert_array_equal(packed[:, :3], rgb.reshape(15, 3)[:, ::-1])


@pytest.mark.parametrize('storage', [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def test_messages_come_back_with_the_definitions_of_the_bag_alone(tmp_path, storage):
    track = TrackedPose('cup', STAMP_NS, 'camera', POSE, 0.75)
    transform = StampedTransform('world', 'camera', STAMP_NS, POSE, is_static=True)
    with BagWriter(tmp_path / 'bag', storage=storage) as writer:
        writer.write('/tf_static', 10, writer.transforms([transform]))
        writer.write('/cup', 20, writer.pose_stamped(track))
        writer.write('/tracks', 30, writer.tracked_objects(STAMP_NS, 'camera', [track]))
    # AnyReader knows nothing of this package: it takes the definitions from the bag.
    store = get_typestore(Stores.ROS2_JAZZY)
    with AnyReader([tmp_path / 'bag'], default_typestore=store) as reader:
        read = {
            item.topic: (time_ns, reader.deserialize(data, item.msgtype))
            for item, time_ns, data in reader.messages()
        }
    assert {topic: time_ns for topic, (time_ns, _) in read.items()} == {
        '/tf_static': 10, '/cup': 20, '/tracks': 30
    }  # fmt: skip
    pose_stamped, array = read['/cup'][1], read['/tracks'][1]
    assert stamp_ns(pose_stamped.header.stamp) == STAMP_NS
    read_back = read_pose(pose_stamped.pose)
    np.testing.assert_array_equal(read_back.translation, POSE.translation)
    np.testing.assert_allclose(read_back.quat_wxyz, POSE.quat_wxyz, rtol=1e-15)
    assert array.objects[0].object_id == 'cup'
    assert array.objects[0].confidence == 0.75
    assert read_pose(array.objects[0].pose).is_close(POSE)
    transforms, faults = read_transforms(read['/tf_static'][1], is_static=True)
    assert faults == []
    assert transforms[0].parent_from_child.is_close(POSE)


def test_late_subscribers_get_the_static_transforms(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        transform = StampedTransform('world', 'camera', 0, Pose(), is_static=True)
        writer.write('/tf_static', 0, writer.transforms([transform]))
        writer.write('/tf', 0, writer.transforms([transform]))
    with Reader(tmp_path / 'bag') as reader:
        durability = {
            item.topic: item.ext.offered_qos_profiles[0].durability.name
            for item in reader.connections
        }
    assert durability == {'/tf_static': 'TRANSIENT_LOCAL', '/tf': 'VOLATILE'}


def test_an_existing_bag_is_not_overwritten(tmp_path):
    (tmp_path / 'bag').mkdir()
    (tmp_path / 'bag' / 'precious').touch()
    with pytest.raises(BagError, match='exists already'):
        BagWriter(tmp_path / 'bag')
    assert (tmp_path / 'bag' / 'precious').exists()


def test_a_place_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / 'file').touch()
    with pytest.raises(BagError, match='cannot be made'), BagWriter(tmp_path / 'file' / 'bag'):
        pass
