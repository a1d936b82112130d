"""Cutting an object without a model out of the live cloud."""

import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError, Pose
from spatial_relations_ros.perception.camera import PinholeCamera
from spatial_relations_ros.perception.cropping import (
    CropConfig,
    crop_object,
    points_near,
    without_models,
)
from spatial_relations_ros.perception.object_models import KnownModel
from spatial_relations_ros.perception.point_cloud2 import PointCloud
from spatial_relations_ros.perception.table import Plane

TABLE = Plane(np.array([0.0, 0.0, 1.0]), 0.0)
CONFIG = CropConfig()


def blob(centre, size, num_points=600, seed=0):
    rng = np.random.default_rng(seed)
    return np.asarray(centre) + rng.uniform(-0.5, 0.5, (num_points, 3)) * size


def box_of(points):
    return points.min(axis=0), points.max(axis=0)


def test_takes_the_object_off_the_table_and_away_from_its_neighbour():
    cup, neighbour = blob((0, 0, 0.05), 0.08), blob((0.15, 0, 0.05), 0.08)
    table = blob((0, 0, 0.0), (0.4, 0.4, 0.01), 3000)
    found = crop_object(
        np.concatenate([table, neighbour, cup]), np.array([0, 0, 0.05]), TABLE, [], [], CONFIG
    )
    np.testing.assert_allclose(box_of(found), box_of(cup[cup[:, 2] > 0.008]))


def test_points_of_known_objects_are_left_out():
    plate = blob((0, 0, 0.015), (0.2, 0.2, 0.01), 4000)
    cup = blob((0, 0, 0.06), 0.06)
    pose = Pose(np.array([0.3, 0.1, 0.0]))
    known = KnownModel((plate - pose.translation).astype(np.float32))
    found = crop_object(
        np.concatenate([plate, cup]), np.array([0, 0, 0.06]), TABLE, [(known, pose)], [], CONFIG
    )
    assert found[:, 2].min() > 0.025
    assert len(found) > 500
    assert len(without_models(plate, [(known, pose)], 0.01)) == 0


def test_two_that_touch_are_divided_by_their_places():
    lower, upper = blob((0, 0, 0.06), 0.08), blob((0, 0, 0.14), 0.08, seed=1)
    both = np.concatenate([lower, upper])
    places = [np.array([0, 0, 0.06]), np.array([0, 0, 0.14])]
    halves = [
        crop_object(both, places[idx], TABLE, [], [places[1 - idx]], CONFIG) for idx in (0, 1)
    ]
    assert halves[0][:, 2].max() < 0.101
    assert halves[1][:, 2].min() > 0.099
    assert sum(map(len, halves)) == len(both)


def test_a_ring_keeps_its_points_when_another_object_stands_in_its_middle():
    rng = np.random.default_rng(0)
    angle = rng.uniform(0, 2 * np.pi, 2000)
    ring = np.stack([0.12 * np.cos(angle), 0.12 * np.sin(angle), 0.02 + 0 * angle], axis=1)
    cup = blob((0, 0, 0.05), 0.06)
    found = crop_object(
        np.concatenate([ring, cup]),
        np.array([0, 0, 0.015]),
        TABLE,
        [],
        [np.array([0, 0, 0.05])],
        CONFIG,
    )
    assert len(found) == len(ring)


def test_too_few_points_are_no_object():
    centre = np.array([0, 0, 0.05])
    assert crop_object(blob(centre, 0.05, 30), centre, TABLE, [], [], CONFIG) is None
    specks = np.concatenate([blob((x, 0, 0.05), 0.004, 20) for x in (-0.1, 0.0, 0.1)])
    assert crop_object(specks, centre, None, [], [], CONFIG) is None
    assert crop_object(np.zeros((0, 3)), centre, TABLE, [], [], CONFIG) is None


def test_the_window_of_pixels_loses_no_point_of_the_ball():
    camera = PinholeCamera(width=160, height=120, fx=150.0, fy=150.0, cx=79.5, cy=59.5)
    rng = np.random.default_rng(0)
    depth = rng.uniform(0.5, 2.0, (120, 160)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.2] = np.nan
    cloud = PointCloud(camera.rays() * depth[..., None])
    for centre in rng.uniform([-0.6, -0.5, 0.2], [0.6, 0.5, 2.0], (40, 3)):
        windowed = points_near(cloud, camera, centre, 0.2)
        naive = cloud.points[np.linalg.norm(cloud.points - centre, axis=1) <= 0.2]
        assert abs(len(windowed) - len(naive)) <= 1  # rounding on the surface of the ball
        np.testing.assert_array_equal(windowed, points_near(cloud, None, centre, 0.2))


@pytest.mark.parametrize('wrong', [{'radius': 0}, {'voxel': 0.5}, {'min_points': 1}])
def test_refuses_impossible_settings(wrong):
    with pytest.raises(ConfigError):
        CropConfig(**wrong)
