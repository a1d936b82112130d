"""Mass and rest poses against closed formulas."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import Manifold

from spatial_relations_ros.datasets.objects.solids import box, mesh_of
from spatial_relations_ros.placement.mass import mass_properties
from spatial_relations_ros.placement.rest_poses import (
    RestKind,
    find_rest_poses,
    footprint_margin,
    rotation_between,
)


def test_mass_of_a_box():
    mesh = mesh_of(box((0.1, 0.2, 0.3), bottom=0.05))
    found = mass_properties(mesh, density=500.0)
    assert found.mass == pytest.approx(0.1 * 0.2 * 0.3 * 500.0, rel=1e-5)
    np.testing.assert_allclose(found.centre, [0.0, 0.0, 0.2], atol=1e-6)


def test_a_cavity_moves_the_centre_of_mass():
    outer, inner = box((0.1, 0.1, 0.1)), box((0.08, 0.08, 0.09), bottom=0.01)
    found = mass_properties(mesh_of(outer - inner), density=1.0)
    volume_outer, volume_inner = 0.001, 0.08 * 0.08 * 0.09
    expected = (volume_outer * 0.05 - volume_inner * 0.055) / (volume_outer - volume_inner)
    assert found.centre[2] == pytest.approx(expected, rel=1e-4)


def test_a_box_rests_on_each_of_its_six_faces():
    mesh = mesh_of(box((0.1, 0.2, 0.3)).translate((0.0, 0.0, -0.15)))
    poses = find_rest_poses(mesh, np.zeros(3))
    kinds = [pose.kind for pose in poses]
    assert len(poses) == 6
    assert kinds.count(RestKind.UPRIGHT) == 1
    assert kinds.count(RestKind.UPSIDE_DOWN) == 1
    # The margin is half of the shorter side of the face, the height half of the third side.
    sizes = sorted((round(2 * p.margin, 4), round(2 * p.centre_height, 4)) for p in poses)
    assert sizes == [(0.1, 0.2), (0.1, 0.2), (0.1, 0.3), (0.1, 0.3), (0.2, 0.1), (0.2, 0.1)]


def test_a_heavy_side_leaves_no_rest_on_a_small_foot():
    foot = box((0.02, 0.02, 0.05))
    arm = box((0.2, 0.02, 0.02), bottom=0.05).translate((0.1, 0.0, 0.0))
    mesh = mesh_of(foot + arm)
    centre = mass_properties(mesh, density=1.0).centre
    kinds = {pose.kind for pose in find_rest_poses(mesh, centre)}
    assert RestKind.UPRIGHT not in kinds
    assert RestKind.UPSIDE_DOWN in kinds


def test_a_ball_has_next_to_no_footprint():
    mesh = mesh_of(Manifold.sphere(0.05, 32))
    poses = find_rest_poses(mesh, np.zeros(3))
    assert all(pose.margin < 0.01 for pose in poses)


def test_footprint_margin_of_a_square():
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    assert footprint_margin(square, np.array([0.25, 0.0])) == pytest.approx(0.75)
    assert footprint_margin(square, np.array([1.5, 0.0])) < 0.0
    assert footprint_margin(np.zeros((3, 2)), np.zeros(2)) == -np.inf


def test_rotation_between_turns_one_vector_into_the_other():
    rng = np.random.default_rng(0)
    pairs = [(np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0]))]
    pairs += [tuple(v / np.linalg.norm(v) for v in rng.normal(size=(2, 3))) for _ in range(5)]
    for source, target in pairs:
        rotation = rotation_between(source, target)
        np.testing.assert_allclose(rotation @ source, target, atol=1e-12)
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(rotation) == pytest.approx(1.0)
