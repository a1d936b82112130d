import numpy as np
import pytest

from spatial_relations_ros.core import Pose, SceneObject, TriangleMesh


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
