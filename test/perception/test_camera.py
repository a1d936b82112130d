"""The camera behind an organised cloud."""

import numpy as np
import pytest

from spatial_relations_ros.perception.camera import PinholeCamera, estimate_camera
from spatial_relations_ros.perception.point_cloud2 import PointCloud

CAMERA = PinholeCamera(width=160, height=120, fx=140.5, fy=138.0, cx=83.25, cy=55.5)


def cloud_of(camera, rng, *, invalid_share=0.3):
    depth = rng.uniform(0.6, 3.0, (camera.height, camera.width)).astype(np.float32)
    depth[rng.random(depth.shape) < invalid_share] = np.nan
    return PointCloud(camera.rays() * depth[..., None])


def test_finds_the_intrinsics_of_a_noisy_cloud_with_holes():
    found = estimate_camera(cloud_of(CAMERA, np.random.default_rng(0)))
    assert (found.width, found.height) == (160, 120)
    np.testing.assert_allclose(
        [found.fx, found.fy, found.cx, found.cy], [140.5, 138.0, 83.25, 55.5], rtol=1e-5
    )


def test_projects_each_point_to_its_own_pixel():
    cloud = cloud_of(CAMERA, np.random.default_rng(1))
    rows, columns = np.nonzero(cloud.finite)
    found_columns, found_rows = CAMERA.project(cloud.points)
    np.testing.assert_array_equal(found_columns, columns)
    np.testing.assert_array_equal(found_rows, rows)


def test_points_that_overflow_are_outside():
    columns, rows = CAMERA.project(np.array([[1e300, -1e300, 1e-300]]))
    assert columns[0] >= CAMERA.width
    assert rows[0] < 0


@pytest.mark.parametrize('kind', ['unorganised', 'shuffled', 'almost empty', 'mirrored'])
def test_finds_none_where_there_is_none(kind):
    rng = np.random.default_rng(2)
    xyz = np.array(cloud_of(CAMERA, rng).xyz)
    if kind == 'unorganised':
        xyz = xyz.reshape(-1, 3)
    elif kind == 'shuffled':
        xyz = rng.permutation(xyz.reshape(-1, 3)).reshape(xyz.shape)
    elif kind == 'almost empty':
        xyz[8:] = np.nan
    else:
        xyz[..., 0] *= -1.0
    assert estimate_camera(PointCloud(xyz)) is None
