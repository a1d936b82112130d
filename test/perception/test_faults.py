"""What sensors, trackers and clocks do wrong, from their messages to the scenes."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from spatial_relations_ros.core import Pose, UnknownObjectError
from spatial_relations_ros.datasets.kinect_simulator import (
    KinectSimulator,
    Surface,
    table_mesh,
)
from spatial_relations_ros.perception.assembler import MAX_WAITING, FrameAssembler
from spatial_relations_ros.perception.camera import PinholeCamera
from spatial_relations_ros.perception.messages import read_pose_stamped, read_transforms
from spatial_relations_ros.perception.point_cloud2 import read_xyz
from spatial_relations_ros.perception.series import NS_PER_SEC
from spatial_relations_ros.perception.track_state import TrackState
from spatial_relations_ros.pipeline import Pipeline

START_SEC = 1_700_000_000.0
TABLE_HEIGHT = 0.7
WELL = (0.0, 0.0, 0.0, 1.0)


def header(stamp_sec, frame_id):
    sec = math.floor(stamp_sec)
    stamp = SimpleNamespace(sec=sec, nanosec=round((stamp_sec - sec) * NS_PER_SEC))
    return SimpleNamespace(stamp=stamp, frame_id=frame_id)


def pose_message(pose, stamp_sec, *, quat_xyzw=None, frame_id='camera'):
    x, y, z = pose.translation
    w, *xyz = pose.quat_wxyz
    qx, qy, qz, qw = (*xyz, w) if quat_xyzw is None else quat_xyzw
    return SimpleNamespace(
        header=header(stamp_sec, frame_id),
        pose=SimpleNamespace(
            position=SimpleNamespace(x=x, y=y, z=z),
            orientation=SimpleNamespace(x=qx, y=qy, z=qz, w=qw),
        ),
    )


def cloud_message(xyz):
    height, width = xyz.shape[:2]
    fields = [
        SimpleNamespace(name=name, offset=4 * idx, datatype=7, count=1)
        for idx, name in enumerate('xyz')
    ]
    return SimpleNamespace(
        height=height,
        width=width,
        fields=fields,
        is_bigendian=False,
        point_step=12,
        row_step=12 * width,
        data=xyz.astype('<f4').tobytes(),
        is_dense=False,
    )


class Rig:
    """A camera, a tracker and /tf as messages; what a node does with them."""

    def __init__(self, tabletop):
        self.tabletop = tabletop
        self.pipeline = Pipeline(models=tabletop)
        self.assembler = FrameAssembler()
        self.cloud = cloud_message(tabletop.cloud.xyz)
        self.send_transform()

    def send_transform(self):
        pose = self.tabletop.world_from_camera
        x, y, z = pose.translation
        qw, qx, qy, qz = pose.quat_wxyz
        item = SimpleNamespace(
            header=header(0.0, 'world'),
            child_frame_id='camera',
            transform=SimpleNamespace(
                translation=SimpleNamespace(x=x, y=y, z=z),
                rotation=SimpleNamespace(x=qx, y=qy, z=qz, w=qw),
            ),
        )
        message = SimpleNamespace(transforms=[item])
        self.assembler.add_transforms(*read_transforms(message, is_static=True))

    def track(self, stamp_sec, *, wrong=None):
        """One pose of each object; ``wrong`` maps ids to quaternions (x, y, z, w)."""
        for object_id in self.tabletop.poses:
            pose = self.tabletop.track(object_id).frame_from_object
            quat_xyzw = (wrong or {}).get(object_id)
            message = pose_message(pose, START_SEC + stamp_sec, quat_xyzw=quat_xyzw)
            self.assembler.add_tracks(*read_pose_stamped(message, object_id))

    def see(self, stamp_sec, *, cloud=None, frame_id='camera'):
        read = read_xyz(self.cloud if cloud is None else cloud)
        stamp_ns = round((START_SEC + stamp_sec) * NS_PER_SEC)
        return self.pipeline.step(self.frame(stamp_ns, frame_id, read))

    def frame(self, stamp_ns, frame_id, cloud):
        """With all that has come; it waits for nothing."""
        self.assembler.add_cloud(stamp_ns, frame_id, cloud, 0)
        frame = self.assembler.take(None)
        assert frame is not None
        return frame

    def run(self, start_sec, num_frames, **wrong):
        """Poses and clouds, ten a second; the last result."""
        for idx in range(num_frames):
            stamp_sec = start_sec + 0.1 * idx
            self.track(stamp_sec, **wrong)
            result = self.see(stamp_sec)
        return result


@pytest.fixture
def rig(tabletop):
    return Rig(tabletop)


def is_well(result):
    return result.problem is None and not result.rejected and len(result.objects) == 3


def test_the_sensor_stops_and_comes_back(rig):
    assert is_well(rig.run(0.0, 3))
    for idx in range(600):  # the tracker goes on
        rig.track(0.3 + idx / 30)
    assert is_well(rig.run(20.4, 1))


def test_nothing_piles_up_while_the_sensor_is_silent(rig):
    for idx in range(3 * MAX_WAITING):
        rig.track(idx / 1000)
    frame = rig.frame(round((START_SEC + 100) * NS_PER_SEC), 'camera', rig.tabletop.cloud)
    assert len(frame.tracks) == MAX_WAITING


def test_the_tracker_stops_and_comes_back(rig):
    rig.run(0.0, 3)
    for idx in range(15):
        result = rig.see(0.3 + 0.1 * idx)
    assert result.objects == {}
    with pytest.raises(UnknownObjectError, match=r'base: the last tracked pose is 1.50 s old'):
        rig.pipeline.scene('base', 'top')
    assert {status.state for status in result.states.values()} == {TrackState.LOST}
    assert is_well(rig.run(1.8, 6))


def test_the_clock_jumps_back_and_forth(rig):
    for start_sec in (0.0, 3600.0, 0.0, -86400.0, 10.0, 9.5, -START_SEC):
        result = rig.run(start_sec, 4)
        assert is_well(result), (start_sec, result.rejected)


def test_a_clock_that_jumps_back_between_poses_and_cloud_costs_one_frame(rig):
    rig.run(0.0, 3)
    rig.track(0.3)
    result = rig.see(-50.0)
    assert result.objects == {}
    with pytest.raises(UnknownObjectError, match='base: no tracked pose has arrived'):
        rig.pipeline.scene('base', 'top')
    assert is_well(rig.run(-49.9, 6))


@pytest.mark.parametrize(
    ('quat_xyzw', 'word'),
    [
        ((math.nan, 0, 0, 1), 'not finite'),
        ((0, 0, 0, math.inf), 'not finite'),
        ((0, 0, 0, 0), 'norm 0'),
        ((0, 0, 2, 2), 'norm 2.8'),
    ],
)
def test_poses_that_are_none_cost_their_object_only(rig, quat_xyzw, word):
    rig.run(0.0, 3)
    result = rig.run(0.3, 8, wrong={'tall': quat_xyzw})
    assert set(result.objects) == {'base', 'top'}
    assert 's old' in result.rejected['tall']
    assert word in result.rejected['tall']
    assert is_well(rig.run(1.1, 6))


def test_a_pose_that_was_never_right_is_named(rig):
    result = rig.run(0.0, 2, wrong={'tall': (0, 0, 0, 0)})
    assert 'tracked pose refused' in result.rejected['tall']


def test_a_cloud_of_a_frame_without_transform_is_passed_over(rig):
    assert is_well(rig.run(0.0, 3))
    rig.track(0.3)
    result = rig.see(0.3, frame_id='nowhere')
    assert "nothing is known of 'nowhere'" in result.problem
    with pytest.raises(UnknownObjectError, match='nowhere'):
        rig.pipeline.scene('base', 'top')
    assert is_well(rig.run(0.4, 1))


def test_a_cloud_that_is_ten_times_larger_gives_the_same_objects(rig):
    tabletop = rig.tabletop
    small = rig.run(0.0, 2)
    scale = math.sqrt(10.0)
    camera = PinholeCamera(1619, 1341, 365.5 * scale, 365.5 * scale, 806.0, 649.5)
    surfaces = [Surface(table_mesh((0.6, 0.9), height=TABLE_HEIGHT))]
    surfaces += [
        Surface(mesh.transformed(tabletop.poses[key])) for key, mesh in tabletop.meshes.items()
    ]
    simulator = KinectSimulator(surfaces, tabletop.world_from_camera, camera)
    xyz = simulator.xyz(simulator.measure(np.random.default_rng(0)))
    rig.track(0.2)
    large = rig.see(0.2, cloud=cloud_message(xyz))
    assert xyz.size >= 10 * tabletop.cloud.xyz.size * 0.99
    assert is_well(large)
    for object_id, item in large.objects.items():
        assert item.support == pytest.approx(small.objects[object_id].support, abs=0.1)
    assert is_well(rig.run(0.3, 1))


def test_a_tracker_that_invents_ids_does_not_fill_the_memory(rig):
    for idx in range(500):
        pose = rig.tabletop.track('base').frame_from_object
        message = pose_message(pose, START_SEC + 0.001 * idx)
        rig.assembler.add_tracks(*read_pose_stamped(message, f'ghost_{idx}'))
    result = rig.see(0.5)
    assert len(result.states) <= 64
    assert is_well(Rig(rig.tabletop).run(0.0, 1))


def test_an_empty_or_blind_cloud_does_not_change_what_is_believed(rig):
    rig.run(0.0, 3)
    blind = cloud_message(np.full((424, 512, 3), np.nan, dtype=np.float32))
    for idx in range(10):
        rig.track(0.3 + 0.1 * idx)
        result = rig.see(0.3 + 0.1 * idx, cloud=blind)
        assert result.problem == 'no finite points in the cloud of 217088'
        assert result.objects == {}
    empty = cloud_message(np.zeros((0, 0, 3), dtype=np.float32))
    assert rig.see(1.3, cloud=empty).problem == 'no finite points in the cloud of 0'
    assert is_well(rig.run(1.4, 1))


def test_a_pose_in_a_frame_that_nobody_knows_is_named(rig):
    rig.run(0.0, 2)
    message = pose_message(Pose(), START_SEC + 0.2, frame_id='head_camera', quat_xyzw=WELL)
    rig.assembler.add_tracks(*read_pose_stamped(message, 'stray'))
    result = rig.run(0.2, 1)
    assert set(result.objects) == {'base', 'tall', 'top'}
    assert "nothing is known of 'head_camera'" in result.rejected['stray']
