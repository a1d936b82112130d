"""The plane under the objects."""

import numpy as np
import pytest

from spatial_relations_ros.perception.table import Plane, find_table


def tilted_plane(rng, *, tilt_rad, height, num_points=2000, noise=0.002):
    points = rng.uniform(-0.5, 0.5, (num_points, 3))
    points[:, 2] = height + np.tan(tilt_rad) * points[:, 0] + rng.normal(0, noise, num_points)
    return points


def test_finds_a_tilted_table_under_clutter():
    rng = np.random.default_rng(0)
    clutter = rng.uniform([-0.5, -0.5, 0.7], [0.5, 0.5, 1.2], (3000, 3))
    points = np.concatenate([tilted_plane(rng, tilt_rad=0.1, height=0.7), clutter])
    table = find_table(rng.permutation(points), np.random.default_rng(1))
    assert np.arccos(table.normal[2]) == pytest.approx(0.1, abs=0.02)
    assert table.normal @ [np.sin(0.1), 0, -np.cos(0.1)] == pytest.approx(-1.0, abs=1e-3)
    assert table.z_at(0.2, -0.3) == pytest.approx(0.7 + 0.2 * np.tan(0.1), abs=0.004)


def test_a_wall_is_no_table():
    rng = np.random.default_rng(0)
    wall = tilted_plane(rng, tilt_rad=0.0, height=0.7)[:, [2, 1, 0]]
    assert find_table(wall, np.random.default_rng(0)) is None
    found = find_table(wall, np.random.default_rng(0), up=(1.0, 0.0, 0.0))
    assert found.offset == pytest.approx(0.7, abs=0.002)


@pytest.mark.parametrize('points', [np.zeros((0, 3)), np.zeros((500, 3)), np.ones((20, 3))])
def test_degenerate_clouds_have_no_table(points):
    assert find_table(points, np.random.default_rng(0)) is None


def test_noise_has_no_table():
    points = np.random.default_rng(0).uniform(-1, 1, (5000, 3))
    assert find_table(points, np.random.default_rng(0)) is None


def test_the_same_points_give_the_same_table():
    points = tilted_plane(np.random.default_rng(0), tilt_rad=0.05, height=0.7)
    first, second = (find_table(points, np.random.default_rng(3)) for _ in range(2))
    assert first.offset == second.offset
    np.testing.assert_array_equal(first.normal, second.normal)


def test_heights_are_signed_distances_from_the_plane():
    plane = Plane(np.array([0.0, 0.6, 0.8]), 0.5)
    point = 0.5 * plane.normal + 0.3 * plane.normal + np.array([1.0, 0.0, 0.0])
    np.testing.assert_allclose(plane.heights(np.stack([point, -point])), [0.3, -1.3])
