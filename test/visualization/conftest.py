import numpy as np
import pytest

from spatial_relations_ros.core import Pose, Scene, SceneObject, TriangleMesh
from spatial_relations_ros.visualization import (
    ShownAnswer,
    ShownCheck,
    ShownImitation,
    ShownStep,
)


def box_mesh(size):
    """A closed box (x, y, z) about the origin, faces outward."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2.0
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = [t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])]
    return TriangleMesh(corners * np.asarray(size), np.array(triangles))


@pytest.fixture
def make_box():
    def make(object_id, size, centre, *, as_cloud=False):
        mesh = box_mesh(size)
        points = mesh.sample_surface(1500, np.random.default_rng(0))
        pose = Pose(np.asarray(centre, dtype=float))
        return SceneObject(object_id, points, pose, mesh=None if as_cloud else mesh)

    return make


def at(*translation, quat=(1.0, 0.0, 0.0, 0.0)):
    return Pose(np.array(translation), np.array(quat))


def scene(base, relative, target):
    box = box_mesh((0.1, 0.1, 0.1))
    cloud = np.random.default_rng(0).random((50, 3)).astype(np.float32) / 10.0
    return Scene(
        SceneObject(base, box.vertices, at(0.0, 0.0, 0.05), mesh=box),
        SceneObject(relative, cloud, target),
    )


@pytest.fixture
def shown():
    """Two answers; the best one has a step on the way, the other one no distance."""
    start = at(0.3, 0.0, 0.0)
    end = at(0.0, 0.0, 0.1, quat=(np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)))
    base = at(0.0, 0.0, 0.05)
    return ShownImitation(
        'cup to tray',
        scene('plate', 'mug', at(0.0, 0.0, 0.1)),
        scene('tray', 'cup', start),
        (
            ShownAnswer((base, end), 0.25, True, (ShownCheck('distance', '0.25', True),)),
            ShownAnswer((base, at(0.1, 0.0, 0.1)), float('nan'), False),
        ),
        (
            ShownStep((base, start), 2.0, 0, True),
            ShownStep((base, at(0.1, 0.0, 0.1)), 1.0, 3, False),
        ),
        (2.0, 1.0, float('nan'), 0.25),
        True,
        'distance 2 before, 0.25 after',
        (('time', '1 s'),),
    )
