"""Bags as frames: every storage, every kind of track, and every fault."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import get_types_from_msg

from spatial_relations_ros.core import BagError, Pose
from spatial_relations_ros.evaluation.bag_reader import (
    BagReader,
    BagTopics,
    iter_raw,
    read_frames,
)
from spatial_relations_ros.evaluation.bag_writer import BagWriter
from spatial_relations_ros.perception.border import StampedTransform, TrackedPose

MS = 1_000_000
DEMO = Path(__file__).parents[2] / 'bags' / 'demo'
RGB = np.zeros((4, 6, 3), dtype=np.uint8)
XYZ = np.zeros((4, 6, 3), dtype=np.float32)


def xyz_of(idx):
    xyz = np.full((4, 6, 3), float(idx), dtype=np.float32)
    xyz[0, 0] = np.nan
    return xyz


def track(object_id, stamp_ns, x=0.0):
    return TrackedPose(object_id, stamp_ns, 'camera', Pose(np.array([x, 0.0, 0.0])))


def record(path, *, storage=StoragePlugin.MCAP, arrays=True):
    """Two clouds, a static and a moving transform, and poses of two objects."""
    with BagWriter(path, storage=storage) as writer:
        static = StampedTransform('world', 'camera', 0, Pose(), is_static=True)
        moving = StampedTransform('world', 'hand', 5 * MS, Pose())
        writer.write('/tf_static', 0, writer.transforms([static]))
        writer.write('/tf', 5 * MS, writer.transforms([moving]))
        for idx, time_ns in enumerate((10 * MS, 30 * MS)):
            tracks = [track('cup', time_ns, 1.0 + idx), track('mug', time_ns)]
            if arrays:
                message = writer.tracked_objects(time_ns, 'camera', tracks)
                writer.write('/tracked_objects', time_ns, message)
            for item in tracks:
                writer.write(f'/simtrack/{item.object_id}', time_ns, writer.pose_stamped(item))
            message = writer.cloud(time_ns - MS, 'camera', xyz_of(idx), RGB)
            writer.write('/points', time_ns + MS, message)
        writer.write('/tracked_objects', 90 * MS, writer.tracked_objects(0, 'camera', []))
    return path


@pytest.mark.parametrize('storage', [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def test_each_cloud_comes_with_what_arrived_before_it(tmp_path, storage):
    first, second = read_frames(record(tmp_path / 'bag', storage=storage))
    assert (first.stamp_ns, second.stamp_ns) == (9 * MS, 29 * MS)
    assert first.frame_id == 'camera'
    np.testing.assert_array_equal(second.cloud.xyz, xyz_of(1))
    assert [item.child_frame for item in first.transforms] == ['camera', 'hand']
    assert [item.is_static for item in first.transforms] == [True, False]
    assert second.transforms == ()
    assert [item.object_id for item in first.tracks] == ['cup', 'mug']
    assert second.tracks[0].frame_from_object.translation[0] == 2.0


def test_pose_topics_that_end_alike_must_be_named(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        for name in ('bowl', 'cup'):
            writer.write(f'/{name}/pose', 0, writer.pose_stamped(track(name, 0)))
        writer.write('/points', MS, writer.cloud(0, 'camera', XYZ, RGB))
    with pytest.raises(BagError, match=r'/bowl/pose and /cup/pose .* --pose-topic "cup='):
        list(read_frames(tmp_path / 'bag'))
    named = {'bowl': '/bowl/pose', 'cup': '/cup/pose'}
    (frame,) = read_frames(tmp_path / 'bag', BagTopics('/points', (), named))
    assert {item.object_id for item in frame.tracks} == {'bowl', 'cup'}


def test_poses_recorded_after_their_cloud_go_with_it(tmp_path):
    """A recorder writes in order of arrival, which differs from one run to the next."""

    def contents(name, late_ms):
        with BagWriter(tmp_path / name) as writer:
            for stamp in (0, 33, 66):
                message = writer.tracked_objects(stamp * MS, 'camera', [track('cup', stamp * MS)])
                writer.write('/tracked_objects', (stamp + late_ms) * MS, message)
                writer.write('/points', (stamp + 5) * MS, writer.cloud(stamp * MS, 'c', XYZ, RGB))
        return [
            (frame.stamp_ns // MS, [item.stamp_ns // MS for item in frame.tracks])
            for frame in read_frames(tmp_path / name)
        ]

    early = contents('early', 0)
    assert early == [(0, [0]), (33, [33]), (66, [66])]
    # The first cloud cannot know that a cup will come.
    assert contents('late', 12) == [(0, []), (33, [0, 33]), (66, [66])]
    # Too late for the wait, but for the first one after each silence.
    assert len(contents('too_late', 200)) == 3


def test_a_clock_that_jumps_back_costs_the_cloud_that_waits(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        for time_ns, stamp in ((0, 9_000 * MS), (1 * MS, 9_033 * MS), (2 * MS, 0)):
            if time_ns == 0:
                message = writer.tracked_objects(stamp, 'camera', [track('cup', stamp)])
                writer.write('/tracked_objects', time_ns, message)
            writer.write('/points', time_ns, writer.cloud(stamp, 'camera', XYZ, RGB))
    with BagReader(tmp_path / 'bag') as reader:
        assert [frame.stamp_ns for frame in reader.frames()] == [9_000 * MS, 0]
        (dropped,) = reader.dropped
    assert (dropped.topic, dropped.time_ns) == ('/points', 2 * MS)
    assert 'clock jumped back' in dropped.reason


@pytest.mark.parametrize('mode', [CompressionMode.FILE, CompressionMode.MESSAGE])
def test_compressed_bags_of_rosbag2_are_read(tmp_path, mode):
    source = record(tmp_path / 'bag')
    writer = Writer(tmp_path / 'packed', version=9, storage_plugin=StoragePlugin.SQLITE3)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with BagReader(source) as reader, writer:
        connections = {}
        for message in reader.raw():
            if message.topic not in connections:
                connections[message.topic] = writer.add_connection(
                    message.topic, message.msgtype, typestore=BagWriter(tmp_path / 'none').types
                )
            writer.write(connections[message.topic], message.time_ns, message.data)
    frames = [list(read_frames(path)) for path in (source, tmp_path / 'packed')]
    assert len(frames[0]) == len(frames[1]) == 2
    for plain, packed in zip(*frames, strict=True):
        assert plain.stamp_ns == packed.stamp_ns
        np.testing.assert_array_equal(plain.cloud.xyz, packed.cloud.xyz)


def test_without_arrays_the_pose_topics_are_taken(tmp_path):
    source = record(tmp_path / 'bag', arrays=False)
    topics = BagTopics('/points', pose_topics={'my_cup': '/simtrack/cup'})
    with BagReader(source, topics) as reader:
        frames = list(reader.frames())
    assert [[item.object_id for item in frame.tracks] for frame in frames] == [['my_cup']] * 2


def test_pose_topics_are_found_by_their_type(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        writer.write('/simtrack/cup', 0, writer.pose_stamped(track('cup', 0)))
        writer.write('/points', 1, writer.cloud(0, 'camera', xyz_of(0), RGB))
    with BagReader(tmp_path / 'bag') as reader:
        assert reader.topics() == BagTopics('/points', (), {'cup': '/simtrack/cup'})
        (frame,) = reader.frames()
    assert [item.object_id for item in frame.tracks] == ['cup']


# As upstream has them; rosbags knows them from nowhere else, as in a bag that a robot recorded.
VISION_MSGS = {
    'Detection3DArray': 'std_msgs/Header header\nvision_msgs/Detection3D[] detections',
    'Detection3D': (
        'std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n'
        'vision_msgs/BoundingBox3D bbox\nstring id'
    ),
    'ObjectHypothesisWithPose': (
        'vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose'
    ),
    'ObjectHypothesis': 'string class_id\nfloat64 score',
    'BoundingBox3D': 'geometry_msgs/Pose center\ngeometry_msgs/Vector3 size',
}


def detections_message(types, stamp_ns, class_id):
    """One detection of a class, 2 m before the camera."""
    for name, text in VISION_MSGS.items():
        types.register(get_types_from_msg(text, f'vision_msgs/msg/{name}'))
    kinds = {name.rsplit('/', 1)[-1]: kind for name, kind in types.types.items()}
    stamp = kinds['Time'](sec=0, nanosec=stamp_ns)
    header = kinds['Header'](stamp=stamp, frame_id='camera')
    unit = kinds['Quaternion'](x=0.0, y=0.0, z=0.0, w=1.0)
    pose = kinds['Pose'](position=kinds['Point'](x=0.0, y=0.0, z=2.0), orientation=unit)
    result = kinds['ObjectHypothesisWithPose'](
        hypothesis=kinds['ObjectHypothesis'](class_id=class_id, score=0.75),
        pose=kinds['PoseWithCovariance'](pose=pose, covariance=np.zeros(36)),
    )
    size = kinds['Vector3'](x=0.1, y=0.1, z=0.1)
    box = kinds['BoundingBox3D'](center=pose, size=size)
    detection = kinds['Detection3D'](header=header, results=[result], bbox=box, id='')
    return kinds['Detection3DArray'](header=header, detections=[detection])


def test_detections_are_read_by_the_definitions_in_the_bag(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        writer.write('/detections', 0, detections_message(writer.types, 5, 'cup'))
        writer.write('/points', 1, writer.cloud(5, 'camera', xyz_of(0), RGB))
    with BagReader(tmp_path / 'bag') as reader:
        assert reader.topics().tracked_objects == ('/detections',)
        (frame,) = reader.frames()
        assert reader.dropped == []
    (seen,) = frame.tracks
    assert (seen.object_id, seen.frame_id, seen.stamp_ns) == ('cup', 'camera', 5)
    assert seen.confidence == 0.75
    np.testing.assert_array_equal(seen.frame_from_object.translation, [0.0, 0.0, 2.0])


def test_raw_messages_are_the_bytes_that_were_written(tmp_path):
    messages = list(iter_raw(record(tmp_path / 'bag')))
    assert [message.time_ns for message in messages] == sorted(m.time_ns for m in messages)
    assert len(messages) == 11
    writer = BagWriter(tmp_path / 'none')
    cloud = writer.cloud(9 * MS, 'camera', xyz_of(0), RGB)
    expected = bytes(writer.types.serialize_cdr(cloud, cloud.__msgtype__))
    (first, _) = (message for message in messages if message.topic == '/points')
    assert first.data == expected
    assert first.msgtype == 'sensor_msgs/msg/PointCloud2'


def test_a_damaged_message_is_noted_and_the_rest_is_read(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        good = writer.cloud(0, 'camera', xyz_of(0), RGB)
        bad = writer.cloud(1, 'camera', xyz_of(0), RGB)
        bad.row_step = 7
        for time_ns, message in enumerate((bad, good)):
            writer.write('/points', time_ns, message)
        connection = writer._connections['/points']
        writer._writer.write(connection, 2, b'\x00\x01\x00\x00\xff\xff\xff\xff')
    with BagReader(tmp_path / 'bag') as reader:
        assert len(list(reader.frames())) == 1
        assert [item.time_ns for item in reader.dropped] == [0, 2]
        assert 'row_step is 7' in reader.dropped[0].reason
        assert 'cannot be decoded as sensor_msgs/msg/PointCloud2' in reader.dropped[1].reason


def test_a_pose_that_is_none_is_a_fault_of_its_frame(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        message = writer.pose_stamped(track('cup', 0))
        message.pose.orientation.w = 9.0
        writer.write('/simtrack/cup', 0, message)
        writer.write('/points', 1, writer.cloud(0, 'camera', xyz_of(0), RGB))
    (frame,) = read_frames(tmp_path / 'bag')
    assert frame.tracks == ()
    assert frame.faults[0].object_id == 'cup'


def test_a_missing_bag_is_named(tmp_path):
    with pytest.raises(BagError, match='no_bag is not a bag'):
        next(read_frames(tmp_path / 'no_bag'))
    (tmp_path / 'folder').mkdir()
    with pytest.raises(BagError, match='folder is not a bag'):
        next(read_frames(tmp_path / 'folder'))


def test_an_empty_bag_is_named(tmp_path):
    with BagWriter(tmp_path / 'bag'):
        pass
    with pytest.raises(BagError, match='bag holds no messages'):
        next(read_frames(tmp_path / 'bag'))


def test_missing_topics_are_named_with_those_that_are_there(tmp_path):
    source = record(tmp_path / 'bag')
    for topics in (
        BagTopics('/kinect2/qhd/points'),
        BagTopics('/tracked_objects'),
        BagTopics('/points', tracked_objects=('/nothing',)),
        BagTopics('/points', pose_topics={'cup': '/points'}),
    ):
        with pytest.raises(BagError, match=r'no .* on /.*; the bag has /points \(sensor_msgs'):
            next(read_frames(source, topics))
    with BagWriter(tmp_path / 'poses') as writer:
        writer.write('/simtrack/cup', 0, writer.pose_stamped(track('cup', 0)))
    with pytest.raises(
        BagError, match=r'no sensor_msgs/msg/PointCloud2 in .*; the bag has /simtr'
    ):
        next(read_frames(tmp_path / 'poses'))


@pytest.mark.parametrize('share', [0.0, 0.5, 0.95])
def test_a_truncated_file_is_named(tmp_path, share):
    source = record(tmp_path / 'bag')
    file = source / 'bag.mcap'
    data = file.read_bytes()
    file.write_bytes(data[: int(share * len(data))])
    with pytest.raises(BagError, match='bag cannot be read'):
        list(read_frames(source))


def test_a_damaged_middle_is_named(tmp_path):
    source = shutil.copytree(DEMO, tmp_path / 'demo')
    file = source / 'demo.mcap'
    data = bytearray(file.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 500_000] = bytes(500_000)  # longer than a chunk
    file.write_bytes(data)
    with pytest.raises(BagError, match='demo cannot be read'):
        list(read_frames(source))


def test_the_demonstration_bag_holds_what_its_description_says():
    with BagReader(DEMO) as reader:
        assert reader.topics().points == '/kinect2/sd/points'
        assert reader.contents['/kinect2/sd/points'] == ('sensor_msgs/msg/PointCloud2', 20)
        assert reader.duration_ns > 3_900 * MS
        frame = next(reader.frames())
    assert frame.frame_id == 'kinect2_ir_optical_frame'
    assert frame.cloud.xyz.shape == (424, 512, 3)
    assert 50_000 < frame.cloud.num_finite < 200_000
    # The pose of the cloud's own image has arrived before the cloud.
    assert {item.stamp_ns for item in frame.tracks} == {frame.stamp_ns}
    assert len(frame.tracks) == 7
    assert {item.child_frame for item in frame.transforms} == {
        'kinect2_link', 'kinect2_ir_optical_frame', 'kinect2_rgb_optical_frame'
    }  # fmt: skip
