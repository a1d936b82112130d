"""Every family: closed surfaces, household sizes, usable openings."""

from __future__ import annotations

import numpy as np
import open3d as o3d
import pytest

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.datasets.objects import (
    CONTAINER_FAMILIES,
    OBJECT_FAMILIES,
    sample_object,
)
from spatial_relations_ros.placement.model import ObjectModel
from spatial_relations_ros.placement.rest_poses import RestKind


@pytest.fixture(scope='module', params=OBJECT_FAMILIES)
def models(request) -> list[ObjectModel]:
    return [sample_object(request.param, np.random.default_rng(0))]


def ray_scene(model: ObjectModel) -> o3d.t.geometry.RaycastingScene:
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        o3d.core.Tensor.from_numpy(np.array(model.mesh.vertices)),
        o3d.core.Tensor.from_numpy(model.mesh.triangles.astype(np.uint32)),
    )
    return scene


def test_surface_is_closed_and_faces_outwards(models):
    for model in models:
        directed = model.mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        assert len(np.unique(directed, axis=0)) == len(directed), 'an edge is used twice one way'
        forwards = {tuple(edge) for edge in directed.tolist()}
        assert all((end, start) in forwards for start, end in forwards), 'an open edge'
        assert model.mass_properties.mass > 0.0, 'inside out'


def test_surface_is_one_piece(models):
    for model in models:
        mesh = o3d.geometry.TriangleMesh(
            o3d.utility.Vector3dVector(model.mesh.vertices.astype(np.float64)),
            o3d.utility.Vector3iVector(np.array(model.mesh.triangles)),
        )
        clusters = mesh.cluster_connected_triangles()[1]
        assert len(clusters) == 1


def test_sizes_are_those_of_a_household(models):
    for model in models:
        extents = 2.0 * model.half_extents
        assert extents.min() > 0.01
        assert 0.05 < extents.max() < 0.45
        assert 0.02 < model.mass_properties.mass < 8.0
        assert len(model.mesh.triangles) < 4000


def test_origin_is_the_centre_of_the_bounding_box(models):
    for model in models:
        vertices = model.mesh.vertices
        np.testing.assert_allclose(vertices.max(axis=0), -vertices.min(axis=0), atol=1e-5)
        np.testing.assert_allclose(vertices.max(axis=0), model.half_extents, atol=1e-5)


def test_natural_rest_is_upright(models):
    for model in models:
        upright = [pose for pose in model.rest_poses if pose.kind is RestKind.UPRIGHT]
        assert upright
        np.testing.assert_allclose(upright[0].rotation, np.eye(3), atol=1e-4)


def test_rest_poses_have_the_centre_of_mass_above_the_footprint(models):
    for model in models:
        for pose in model.rest_poses[:6]:
            vertices = model.mesh.vertices @ pose.rotation.T
            footprint = vertices[vertices[:, 2] < vertices[:, 2].min() + 1.5e-3, :2]
            centre = (pose.rotation @ model.mass_properties.centre)[:2]
            for angle in np.linspace(0.0, 2.0 * np.pi, 16):
                direction = np.array([np.cos(angle), np.sin(angle)])
                assert (footprint @ direction).max() >= centre @ direction + 0.9 * pose.margin


def test_opening_is_free_down_to_the_floor(models):
    for model in models:
        opening = model.opening
        if opening is None:
            continue
        scene = ray_scene(model)
        for share in (0.0, 0.9):
            for axis, half in enumerate(
                np.minimum(opening.floor_half_size, opening.rim_half_size)
            ):
                start = [*opening.centre, opening.rim_z + 0.05]
                start[axis] += share * half
                ray = np.array([[*start, 0.0, 0.0, -1.0]], dtype=np.float32)
                hit = scene.cast_rays(o3d.core.Tensor.from_numpy(ray))['t_hit'].numpy()[0]
                assert start[2] - hit == pytest.approx(opening.floor_z, abs=2e-4)
        # Only a pan's handle reaches above the rim.
        assert model.half_extents[2] - 0.012 < opening.rim_z < model.half_extents[2] + 1e-5


def test_points_lie_on_the_surface_and_cover_it(models):
    model = models[0]
    points = model.points(2000, np.random.default_rng(0))
    assert points.shape == (2000, 3)
    assert points.dtype == np.float32
    distance = ray_scene(model).compute_distance(o3d.core.Tensor.from_numpy(points)).numpy()
    assert distance.max() < 2e-4  # the closest point on a sliver is no better known
    np.testing.assert_allclose(np.abs(points).max(axis=0), model.half_extents, atol=0.03)


def test_same_seed_same_object_other_seed_other_object(models):
    family = models[0].family
    again = sample_object(family, np.random.default_rng(0))
    np.testing.assert_array_equal(again.mesh.vertices, models[0].mesh.vertices)
    np.testing.assert_array_equal(again.mesh.triangles, models[0].mesh.triangles)
    assert dict(again.dimensions) == dict(models[0].dimensions)
    other = sample_object(family, np.random.default_rng(1))
    assert dict(other.dimensions) != dict(models[0].dimensions)


def test_unknown_family_names_the_known_ones():
    with pytest.raises(ConfigError, match=r'samovar.*bowl'):
        sample_object('samovar', np.random.default_rng(0))


def test_families_offer_every_role():
    assert len(OBJECT_FAMILIES) >= 60
    assert set(CONTAINER_FAMILIES) < set(OBJECT_FAMILIES)
    assert len(CONTAINER_FAMILIES) >= 20


def test_containers_are_clearly_deep_and_hollows_clearly_shallow(models):
    for model in models:
        assert model.is_container == (model.family in CONTAINER_FAMILIES)
        if model.opening is not None and not model.is_container:
            assert model.opening.depth < 0.031
