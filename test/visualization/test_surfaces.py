import numpy as np
import pytest

from spatial_relations_ros.core import Pose, SceneObject
from spatial_relations_ros.visualization.surfaces import (
    MAX_BEADS,
    smooth_corner_normals,
    surface_of,
)


def tube(num_sides):
    angle = np.arange(num_sides) * 2.0 * np.pi / num_sides
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    vertices = np.concatenate([np.c_[ring, np.zeros(num_sides)], np.c_[ring, np.ones(num_sides)]])
    this, following = np.arange(num_sides), np.roll(np.arange(num_sides), -1)
    triangles = np.concatenate(
        [
            np.stack([this, following, following + num_sides], axis=1),
            np.stack([this, following + num_sides, this + num_sides], axis=1),
        ]
    )
    return vertices.astype(np.float32), triangles.astype(np.int32)


def test_shallow_edges_become_smooth():
    vertices, triangles = tube(32)
    normals = smooth_corner_normals(vertices, triangles)
    radial = vertices[triangles] * [1.0, 1.0, 0.0]
    assert normals == pytest.approx(radial, abs=0.06)


def test_creases_stay_sharp():
    vertices, triangles = tube(4)
    normals = smooth_corner_normals(vertices, triangles)
    assert np.ptp(normals, axis=1).max() < 1e-6


def test_repeated_vertices_are_welded():
    vertices, triangles = tube(32)
    loose = vertices[triangles].reshape(-1, 3)
    separate = smooth_corner_normals(loose, np.arange(len(loose)).reshape(-1, 3))
    assert separate == pytest.approx(smooth_corner_normals(vertices, triangles), abs=1e-5)


def test_beads_sit_on_the_points_and_are_capped():
    points = np.random.default_rng(0).uniform(-0.1, 0.1, (3 * MAX_BEADS, 3)).astype(np.float32)
    pose = Pose(np.array([1.0, 2.0, 3.0]))
    surface = surface_of(SceneObject('cloud', points, pose))
    num_beads = len(surface.vertices) // 12
    assert num_beads <= MAX_BEADS
    centres = surface.vertices.reshape(num_beads, 12, 3).mean(axis=1)
    assert centres == pytest.approx(points[::3] + [1.0, 2.0, 3.0], abs=1e-5)
    # Outward normals: along corner minus centre.
    corners = surface.vertices[surface.triangles[:20]]
    outward = corners - centres[0]
    assert (np.einsum('tcx,tcx->tc', outward, surface.corner_normals[:20]) > 0).all()
