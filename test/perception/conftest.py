"""A table top with three boxes before a simulated Kinect2, and a floor that is larger."""

from dataclasses import dataclass

import numpy as np
import pytest

from spatial_relations_ros.core import Pose, TriangleMesh
from spatial_relations_ros.datasets.kinect_simulator import (
    SD_CAMERA,
    KinectSimulator,
    Surface,
    look_at,
    table_mesh,
)
from spatial_relations_ros.perception.border import Frame, StampedTransform, TrackedPose
from spatial_relations_ros.perception.object_models import KnownModel
from spatial_relations_ros.perception.point_cloud2 import PointCloud

TABLE_HEIGHT = 0.7
STAMP_NS = 1_700_000_000_000_000_000
CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
FACES = [
    [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
    [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
]  # fmt: skip


def box_mesh(size):
    return TriangleMesh(CORNERS * np.asarray(size) / 2, np.array(FACES))


@dataclass
class Tabletop:
    """Meshes and true poses by object id, the camera's pose, and one measured cloud."""

    meshes: dict
    poses: dict
    world_from_camera: Pose
    cloud: PointCloud

    def find(self, object_id):
        """As a source of models."""
        if object_id not in self.meshes:
            return None
        mesh = self.meshes[object_id]
        return KnownModel(mesh.sample_surface(4000, np.random.default_rng(0)), mesh)

    def track(self, object_id, *, stamp_ns=STAMP_NS, offset=(0, 0, 0), **changes):
        """The true pose as a tracker in the camera's frame tells it."""
        world_from_object = Pose(np.asarray(offset, dtype=float)) @ self.poses[object_id]
        pose = self.world_from_camera.inverse() @ world_from_object
        return TrackedPose(object_id, stamp_ns, 'camera', pose, **changes)

    def camera_transform(self):
        return StampedTransform('world', 'camera', 0, self.world_from_camera, is_static=True)

    def frame(self, tracks=None, *, stamp_ns=STAMP_NS, cloud=None, transforms=None):
        """A frame with all objects tracked at their true poses unless told otherwise."""
        if tracks is None:
            tracks = [self.track(object_id, stamp_ns=stamp_ns) for object_id in self.poses]
        if transforms is None:
            transforms = (self.camera_transform(),)
        cloud = self.cloud if cloud is None else cloud
        return Frame(stamp_ns, 'camera', cloud, tuple(tracks), transforms)


@pytest.fixture(scope='session')
def tabletop():
    sizes = {'base': (0.16, 0.12, 0.10), 'tall': (0.06, 0.06, 0.20), 'top': (0.07, 0.07, 0.05)}
    places = {
        'base': (0.0, 0.2, TABLE_HEIGHT + 0.05),
        'tall': (0.1, -0.2, TABLE_HEIGHT + 0.10),
        'top': (0.0, 0.2, TABLE_HEIGHT + 0.125),
    }
    meshes = {name: box_mesh(size) for name, size in sizes.items()}
    poses = {name: Pose(np.array(place)) for name, place in places.items()}
    world_from_camera = look_at((-0.7, 0.0, TABLE_HEIGHT + 0.8), (0.05, 0.0, TABLE_HEIGHT))
    surfaces = [
        Surface(table_mesh((0.6, 0.9), height=TABLE_HEIGHT)),
        Surface(table_mesh((6.0, 6.0), height=0.0)),
        *(Surface(meshes[name].transformed(poses[name])) for name in meshes),
    ]
    simulator = KinectSimulator(surfaces, world_from_camera, SD_CAMERA)
    cloud = PointCloud(simulator.xyz(simulator.measure(np.random.default_rng(0))))
    return Tabletop(meshes, poses, world_from_camera, cloud)


@pytest.fixture(scope='session')
def box_of():
    """Makes the mesh of a box from its size."""
    return box_mesh
