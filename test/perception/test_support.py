"""What a depth image says about a model."""

import math

import numpy as np
import pytest

from spatial_relations_ros.core import Pose
from spatial_relations_ros.perception.camera import PinholeCamera
from spatial_relations_ros.perception.point_cloud2 import PointCloud
from spatial_relations_ros.perception.support import SupportCount, count_support

CAMERA = PinholeCamera(width=200, height=150, fx=180.0, fy=180.0, cx=99.5, cy=74.5)
TOLERANCE = 0.02


def wall_cloud(depth):
    """A cloud whose depth is a number or an image."""
    image = np.broadcast_to(np.asarray(depth, dtype=np.float32), (150, 200))
    return PointCloud(CAMERA.rays() * image[..., None])


def ball_points(depth, num_points=1500):
    """A ball of radius 0.1 on the optical axis, its near side at ``depth``."""
    points = np.random.default_rng(0).normal(size=(num_points, 3))
    points *= 0.1 / np.linalg.norm(points, axis=1, keepdims=True)
    return points + [0.0, 0.0, depth + 0.1]


def ball_depth(depth):
    """Depth image of that ball before nothing."""
    rays = CAMERA.rays().astype(float)
    centre = np.array([0.0, 0.0, depth + 0.1])
    square = (rays**2).sum(-1)
    along = rays @ centre
    root = along**2 - square * (centre @ centre - 0.01)
    with np.errstate(invalid='ignore'):
        return (along - np.sqrt(root)) / square


def count(points, cloud):
    return count_support(points, cloud, CAMERA, tolerance=TOLERANCE)


def test_a_model_at_its_true_place_is_confirmed_although_half_of_it_is_hidden():
    support = count(ball_points(1.0), wall_cloud(ball_depth(1.0))).support
    assert support > 0.97


def test_a_model_before_the_measured_surface_is_contradicted():
    result = count(ball_points(1.0), wall_cloud(2.0))
    assert result.num_confirmed == 0
    assert result.num_occluded == 0
    assert result.support == 0.0


def test_what_is_behind_something_is_not_counted():
    result = count(ball_points(1.0), wall_cloud(0.6))
    assert result.num_confirmed == result.num_contradicted == 0
    assert math.isnan(result.support)


def test_an_occluder_before_one_half_leaves_the_other_half_to_decide():
    depth = ball_depth(1.0)
    depth[:, :100] = 0.5
    result = count(ball_points(1.0), wall_cloud(depth))
    assert result.num_occluded > 0.3 * result.num_confirmed
    assert result.support > 0.95


def test_missing_returns_are_evidence_of_nothing():
    result = count(ball_points(1.0), wall_cloud(np.nan))
    assert result.num_unmeasured > 500
    assert math.isnan(result.support)
    assert math.isnan(count(ball_points(1.0), wall_cloud(np.inf)).support)


@pytest.mark.parametrize('offset', [(0.0, 0.0, -0.5), (0.0, 0.0, -1.2), (5.0, 0.0, 0.0)])
def test_models_outside_of_the_view_are_not_judged(offset):
    points = Pose(np.array(offset)).apply(ball_points(0.0))
    assert math.isnan(count(points, wall_cloud(2.0)).support)


def test_support_falls_as_the_model_moves_away():
    cloud = wall_cloud(np.nan_to_num(ball_depth(1.0), nan=2.0))
    supports = [
        count(ball_points(1.0) + [shift, 0.0, 0.0], cloud).support for shift in (0, 0.05, 0.1, 0.3)
    ]
    assert supports == sorted(supports, reverse=True)
    assert supports[0] > 0.9
    assert supports[-1] == 0.0


def test_support_is_the_confirmed_share_of_what_counts():
    assert SupportCount(30, 10, 500, 0).support == 0.75
    assert math.isnan(SupportCount(10, 5, 0, 0).support)
