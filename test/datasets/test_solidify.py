"""Solids from clouds and from meshes with faults."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import open3d as o3d
import pytest

from spatial_relations_ros.core import InvalidSceneError, TriangleMesh
from spatial_relations_ros.datasets.object_files import load_object_model
from spatial_relations_ros.datasets.objects import sample_object
from spatial_relations_ros.datasets.solidify import is_watertight, solid_from_cloud, watertight

UNKNOWN_OBJECTS = Path(__file__).resolve().parents[2].parent / 'shared/data/unknown_objects'
NUM_POINTS = 40_000


def made(family: str) -> TriangleMesh:
    return sample_object(family, np.random.default_rng(1)).mesh


def volume_of(mesh: TriangleMesh) -> float:
    corners = mesh.vertices[mesh.triangles].astype(np.float64)
    return float(np.einsum('ij,ij->', corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))) / 6


def signed_distances(mesh: TriangleMesh, points) -> np.ndarray:
    caster = o3d.t.geometry.RaycastingScene()
    caster.add_triangles(mesh.vertices, mesh.triangles.astype(np.uint32))
    return caster.compute_signed_distance(np.asarray(points, dtype=np.float32)).numpy()


@pytest.mark.parametrize('family', ['mug', 'box', 'glass', 'ring', 'quadruped'])
def test_a_cloud_gives_back_its_solid(family):
    mesh = made(family)
    solid = solid_from_cloud(mesh.sample_surface(NUM_POINTS, np.random.default_rng(0)))
    assert is_watertight(solid)
    assert len(solid.triangles) <= 6000
    assert volume_of(solid) == pytest.approx(volume_of(mesh), rel=0.06)
    extent = np.ptp(mesh.vertices, axis=0).max()
    surface = mesh.sample_surface(5000, np.random.default_rng(5))
    assert np.abs(signed_distances(solid, surface)).mean() < 0.005 * extent


def test_the_mouth_of_a_container_stays_open():
    model = sample_object('cup', np.random.default_rng(1))
    solid = solid_from_cloud(model.points(NUM_POINTS, np.random.default_rng(0)))
    opening = model.opening
    assert opening is not None
    middle = [*opening.centre, 0.5 * (opening.rim_z + opening.floor_z)]
    below_floor = [*opening.centre, 0.5 * (opening.floor_z + model.mesh.vertices[:, 2].min())]
    outside, inside = signed_distances(solid, [middle, below_floor])
    assert outside > 0.5 * min(opening.floor_half_size)
    assert inside < 0.0


def test_a_hole_that_the_scanner_left_does_not_empty_the_solid():
    mesh = made('box')
    points = mesh.sample_surface(NUM_POINTS, np.random.default_rng(0))
    top = points[:, 2] > mesh.vertices[:, 2].max() - 1e-4
    hole = top & (np.linalg.norm(points[:, :2], axis=1) < 0.05 * np.ptp(points, axis=0).max())
    assert hole.sum() > 50
    assert volume_of(solid_from_cloud(points[~hole])) == pytest.approx(volume_of(mesh), rel=0.05)


def test_the_solid_depends_on_the_points_alone_and_follows_their_size():
    points = made('box').sample_surface(5000, np.random.default_rng(0))
    once, again = solid_from_cloud(points), solid_from_cloud(points.copy())
    np.testing.assert_array_equal(once.vertices, again.vertices)
    np.testing.assert_array_equal(once.triangles, again.triangles)
    larger = solid_from_cloud(100.0 * points)
    assert volume_of(larger) == pytest.approx(1e6 * volume_of(once), rel=0.02)


def test_half_a_million_points_are_thinned_to_the_same_solid():
    mesh = made('mug')
    points = mesh.sample_surface(500_000, np.random.default_rng(0))
    thinned, sparse = solid_from_cloud(points), solid_from_cloud(points[:NUM_POINTS])
    assert volume_of(thinned) == pytest.approx(volume_of(mesh), rel=0.06)
    surface = mesh.sample_surface(5000, np.random.default_rng(5))
    off = [np.abs(signed_distances(solid, surface)).mean() for solid in (thinned, sparse)]
    assert off[0] <= off[1] + 1e-4
    np.testing.assert_array_equal(solid_from_cloud(points).vertices, thinned.vertices)


@pytest.mark.parametrize('name', ['armadillo', 'bunny', 'teapot', 'torus', 'open_box'])
def test_unknown_objects_become_solids(name):
    paths = sorted(UNKNOWN_OBJECTS.glob(f'{name}.*'))
    if not paths:
        pytest.skip(f'needs {name} beside the repository')
    mesh, points = load_object_model(paths[0])
    points = 0.15 * points / np.ptp(points, axis=0).max()
    if mesh is None:
        solid = solid_from_cloud(points)
    else:
        scale = 0.15 / np.ptp(mesh.vertices, axis=0).max()
        solid = watertight(TriangleMesh(scale * mesh.vertices, mesh.triangles))
    assert is_watertight(solid)
    assert volume_of(solid) > 0.0
    assert np.abs(signed_distances(solid, points)).mean() < 0.001
    if name == 'bunny':
        assert volume_of(solid) > 5e-4, 'it is not hollow, though its base has holes'
    if name == 'torus':
        # Radii 1 and 0.25 of a whole of 2.5, at 0.15 m.
        expected = 2.0 * np.pi**2 * 0.06 * 0.015**2
        assert volume_of(solid) == pytest.approx(expected, rel=0.05)
        assert signed_distances(solid, [points.mean(axis=0)])[0] > 0.04


def test_a_watertight_mesh_is_returned_as_it_is():
    mesh = made('mug')
    assert watertight(mesh) is mesh


def test_repeated_vertices_and_turned_triangles_are_put_right():
    mesh = made('mug')
    corners = mesh.vertices[mesh.triangles].reshape(-1, 3)
    triangles = np.arange(len(corners)).reshape(-1, 3)
    triangles[::3] = triangles[::3, ::-1]
    repaired = watertight(TriangleMesh(corners, triangles))
    assert is_watertight(repaired)
    assert volume_of(repaired) == pytest.approx(volume_of(mesh), rel=1e-3)


def test_a_mesh_inside_out_is_turned():
    mesh = made('box')
    repaired = watertight(TriangleMesh(mesh.vertices, mesh.triangles[:, ::-1]))
    assert volume_of(repaired) == pytest.approx(volume_of(mesh))


def test_small_holes_are_closed():
    mesh = made('quadruped')
    holed = TriangleMesh(mesh.vertices, mesh.triangles[30:])
    assert not is_watertight(holed)
    repaired = watertight(holed)
    assert is_watertight(repaired)
    assert volume_of(repaired) == pytest.approx(volume_of(mesh), rel=0.05)


def test_a_box_of_single_sheets_stays_open():
    closed = o3d.geometry.TriangleMesh.create_box(0.1, 0.1, 0.1)
    vertices, triangles = np.asarray(closed.vertices), np.asarray(closed.triangles)
    lid = (vertices[triangles][:, :, 2] > 0.09).all(axis=1)
    assert lid.sum() == 2
    solid = watertight(TriangleMesh(vertices, triangles[~lid]))
    assert is_watertight(solid)
    middle, wall = signed_distances(solid, [[0.05, 0.05, 0.05], [0.0, 0.05, 0.05]])
    assert middle > 0.04
    assert abs(wall) < 0.002
    assert 0.0 < volume_of(solid) < 0.2e-3


@pytest.mark.parametrize(
    ('points', 'complaint'),
    [
        (np.zeros((300, 2)), r'shape \(N, 3\), got \(300, 2\)'),
        (np.random.default_rng(0).random((50, 3)), 'at least 200 points; got 50'),
        (np.full((300, 3), np.nan), '300 of 300 points are not finite'),
        (np.ones((300, 3)), 'no extent'),
    ],
)
def test_clouds_that_are_no_solid(points, complaint):
    with pytest.raises(InvalidSceneError, match=complaint):
        solid_from_cloud(points)


def test_a_mesh_without_extent_is_refused():
    with pytest.raises(InvalidSceneError, match='no extent'):
        watertight(TriangleMesh(np.ones((3, 3)), np.array([[0, 1, 2]])))
