"""Objects without a model over several views of a simulated Kinect2."""

import numpy as np
import pytest

from spatial_relations_ros.core import CloudSource, Pose
from spatial_relations_ros.datasets.kinect_simulator import (
    SD_CAMERA,
    KinectSimulator,
    Surface,
    look_at,
    table_mesh,
)
from spatial_relations_ros.perception.border import Frame, StampedTransform, TrackedPose
from spatial_relations_ros.perception.point_cloud2 import PointCloud
from spatial_relations_ros.perception.scene_perception import ScenePerception
from spatial_relations_ros.perception.track_state import TrackState

SEC = 1_000_000_000
TABLE_HEIGHT = 0.7
CAMERA = look_at((-0.7, 0.0, TABLE_HEIGHT + 0.6), (0.0, 0.0, TABLE_HEIGHT))


def turned(degrees, place=(0.0, 0.0, TABLE_HEIGHT + 0.06)):
    half = np.deg2rad(degrees) / 2
    return Pose(np.array(place), np.array([np.cos(half), 0.0, 0.0, np.sin(half)]))


class Turntable:
    """A box that turns before the camera."""

    def __init__(self, mesh):
        self.mesh = mesh
        self.perception = ScenePerception()
        self.rng = np.random.default_rng(0)
        self.stamp_ns = 0

    def step(self, pose, *, tracked=None, hand=None):
        """One frame; the tracker says ``tracked``, the truth is ``pose``."""
        surfaces = [
            Surface(table_mesh((0.9, 0.9), height=TABLE_HEIGHT)),
            Surface(self.mesh.transformed(pose)),
        ]
        if hand is not None:
            surfaces.append(Surface(self.mesh.transformed(hand)))
        simulator = KinectSimulator(surfaces, CAMERA, SD_CAMERA)
        cloud = PointCloud(simulator.xyz(simulator.measure(self.rng)))
        self.stamp_ns += SEC // 10
        track = TrackedPose('box', self.stamp_ns, 'world', tracked or pose)
        transform = StampedTransform('world', 'camera', 0, CAMERA, is_static=True)
        return self.perception.step(Frame(self.stamp_ns, 'camera', cloud, (track,), (transform,)))


@pytest.fixture
def turntable(box_of):
    return Turntable(box_of((0.10, 0.07, 0.12)))


def faces_seen(points, size=(0.10, 0.07, 0.12)):
    """Which of the four upright faces have points."""
    half = np.array(size) / 2
    on_face = [points[:, axis] * sign > half[axis] - 0.006 for axis in (0, 1) for sign in (1, -1)]
    middle = np.abs(points[:, 2]) < 0.03
    return [int((face & middle).sum() > 40) for face in on_face]


def test_sides_that_were_seen_before_are_remembered(turntable):
    first = turntable.step(turned(0)).objects['box']
    for degrees in range(0, 375, 15):
        last = turntable.step(turned(degrees)).objects['box']
    assert sum(faces_seen(first.points)) <= 2
    assert sum(faces_seen(last.points)) == 4
    assert last.source == CloudSource.OBSERVED
    outside = np.abs(last.points) - np.array([0.05, 0.035, 0.06])
    assert (outside.max(axis=1) < 0.01).mean() > 0.98
    assert len(last.points) < 20_000 + len(first.points) * 2


def test_the_memory_does_not_grow_while_nothing_changes(turntable):
    counts = [len(turntable.step(turned(30)).objects['box'].points) for _ in range(25)]
    assert max(counts[10:]) < 1.1 * min(counts[10:])


def test_an_object_behind_a_hand_is_what_was_seen_of_it(turntable):
    for _ in range(4):
        seen = turntable.step(turned(0)).objects['box']
    # Large before the lens: of the box nothing is left in view.
    towards_camera = CAMERA.translation + 0.62 * (turned(0).translation - CAMERA.translation)
    hidden = turntable.step(turned(0), hand=turned(0, towards_camera))
    assert hidden.states['box'].state is TrackState.TRACKED
    assert len(hidden.objects['box'].points) > 0.3 * len(seen.points)


def test_a_memory_that_no_longer_fits_starts_anew(turntable):
    """The box stays; its pose turns as if it had been laid down: over a silence, no jump."""
    for _ in range(4):
        turntable.step(turned(0))
    turntable.stamp_ns += SEC
    lying = Pose(turned(0).translation + [0.0, 0.0, 0.0], np.array([0.5, 0.5, 0.5, 0.5]))
    slipped = Pose(lying.translation + [0.08, 0.09, 0.05], lying.quat_wxyz)
    result = turntable.step(turned(0), tracked=slipped)
    assert result.states['box'].state is TrackState.UNCERTAIN
    assert 'not what was seen of it before' in result.rejected['box']
    for _ in range(11):
        result = turntable.step(turned(0), tracked=slipped)
    assert result.states['box'].state is TrackState.TRACKED


def test_without_a_camera_memory_works_by_distance(box_of):
    mesh = box_of((0.10, 0.07, 0.12))
    turntable = Turntable(mesh)
    perception = turntable.perception
    points = turned(0).apply(mesh.sample_surface(3000, np.random.default_rng(0)))
    ground = np.random.default_rng(1).uniform(-0.4, 0.4, (6000, 3)) * [1, 1, 0]
    cloud = PointCloud(np.vstack([points, ground + [0, 0, TABLE_HEIGHT]]))

    def step(stamp_ns, tracked):
        track = TrackedPose('box', stamp_ns, 'world', tracked)
        return perception.step(Frame(stamp_ns, 'world', cloud, (track,)))

    for idx in range(4):
        result = step(idx * SEC // 10, turned(0))
    assert result.states['box'].state is TrackState.TRACKED
    away = turned(0, (0.12, 0.12, TABLE_HEIGHT + 0.1))
    assert step(3 * SEC, away).states['box'].state is TrackState.UNCERTAIN
