"""The simulated Kinect2: geometry, noise and blind spots."""

import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError, Pose, TriangleMesh
from spatial_relations_ros.datasets.kinect_simulator import (
    QHD_CAMERA,
    SD_CAMERA,
    KinectSimulator,
    SensorModel,
    Surface,
    axial_noise_sigma,
    look_at,
    table_mesh,
)
from spatial_relations_ros.perception.camera import estimate_camera
from spatial_relations_ros.perception.point_cloud2 import PointCloud

STRAIGHT = Pose()  # looks along +z


def wall(depth, *, half=5.0, tilt_rad=0.0, centre_x=0.0):
    """A square across the optical axis, turned about the camera's y axis."""
    x, y = np.array([-half, half, half, -half]), np.array([-half, -half, half, half])
    corners = np.stack([centre_x + x * np.cos(tilt_rad), y, depth + x * np.sin(tilt_rad)], axis=1)
    return Surface(TriangleMesh(corners, np.array([[0, 1, 2], [0, 2, 3]])))


def measured(surfaces, *, seed=0, camera=SD_CAMERA, **sensor):
    simulator = KinectSimulator(surfaces, STRAIGHT, camera, SensorModel(**sensor))
    image = simulator.measure(np.random.default_rng(seed))
    return simulator, image


@pytest.mark.parametrize('camera', [SD_CAMERA, QHD_CAMERA])
def test_points_lie_on_the_surface_and_on_their_pixels_rays(camera):
    simulator, image = measured([wall(1.5)], camera=camera)
    xyz = simulator.xyz(image)
    assert xyz.shape == (camera.height, camera.width, 3)
    assert np.nanmedian(xyz[..., 2]) == pytest.approx(1.5, abs=0.001)
    found = estimate_camera(PointCloud(xyz))
    np.testing.assert_allclose(
        [found.fx, found.fy, found.cx, found.cy],
        [camera.fx, camera.fy, camera.cx, camera.cy],
        rtol=1e-4,
    )


@pytest.mark.parametrize('depth', [0.8, 1.5, 3.0])
def test_noise_is_that_of_the_model_and_grows_with_distance(depth):
    _, image = measured([wall(depth)])
    middle = image.depth_mm[150:250, 200:300].astype(float)
    expected_mm = 1.5 - 0.5 * depth + 0.3 * depth**2
    # Rounding to millimetres adds a twelfth of a square millimetre.
    assert middle.std() == pytest.approx(np.sqrt(expected_mm**2 + 1 / 12), rel=0.05)
    assert middle.mean() == pytest.approx(1000 * depth, abs=0.15)


def test_noise_grows_with_the_angle():
    sigma = axial_noise_sigma(np.full(3, 1.0), np.deg2rad([0.0, 45.0, 75.0]))
    assert sigma[0] == pytest.approx(0.0013)
    assert sigma[1] == pytest.approx(0.0014)
    assert sigma[2] == pytest.approx(0.0013 + 0.0001 * 25.0)
    _, straight = measured([wall(1.5)])
    _, tilted = measured([wall(1.5, tilt_rad=np.deg2rad(65))])
    rows = np.s_[100:300, 254]
    assert tilted.depth_mm[rows].std() > 1.2 * straight.depth_mm[rows].std()


def test_depth_is_in_whole_millimetres():
    simulator, image = measured([wall(1.5)])
    assert image.depth_mm.dtype == np.uint16
    depth = simulator.xyz(image)[..., 2]
    np.testing.assert_allclose(depth * 1000, np.rint(depth * 1000), atol=1e-3)


def test_nothing_comes_back_where_nothing_is_or_out_of_range():
    simulator, image = measured([wall(1.5, half=0.2)])
    xyz = simulator.xyz(image)
    assert np.isnan(xyz[0, 0]).all()
    assert (np.isnan(xyz).all(axis=-1) == np.isnan(xyz).any(axis=-1)).all()
    assert np.isfinite(xyz[205, 255]).all()
    for depth in (0.3, 5.0):
        assert not measured([wall(depth)])[1].depth_mm.any()


def test_grazing_surfaces_fade_out():
    def share(tilt_deg):
        _, image = measured([wall(1.5, half=0.3, tilt_rad=np.deg2rad(tilt_deg))], edge_step=9.0)
        return (image.depth_mm[:, 254] > 0).mean()

    shares = [share(angle) for angle in (60, 78, 82, 86)]
    assert shares[0] > 1.3 * shares[1] > 1.3 * shares[2]
    assert shares[3] == 0.0


def test_edges_lose_their_pixels_but_for_a_few_that_fly():
    front, back = wall(1.0, half=0.2), wall(1.5)
    _, image = measured([front, back], flying_share=0.0)
    depth = image.depth_mm[205].astype(int)
    steps = np.flatnonzero(depth == 0)
    assert len(steps) == 4  # two pixels at each side of the front
    assert set(np.round(depth[depth > 0], -2)) == {1000, 1500}
    _, flying = measured([front, back], flying_share=0.5)
    between = (flying.depth_mm > 1050) & (flying.depth_mm < 1450)
    assert 100 < between.sum() < 1000


def test_the_same_seed_gives_the_same_image():
    images = [measured([wall(1.5)], seed=seed)[1].depth_mm for seed in (3, 3, 4)]
    np.testing.assert_array_equal(images[0], images[1])
    assert (images[0] != images[2]).any()


def test_colours_are_those_of_the_nearest_surface():
    front = Surface(wall(1.0, half=0.2).mesh, (200, 0, 0))
    _, image = measured([front, Surface(wall(1.5).mesh, (0, 0, 200))])
    assert tuple(image.rgb[205, 255]) == (200, 0, 0)
    assert tuple(image.rgb[205, 30] > 100) == (False, False, True)


def test_a_camera_on_a_mast_sees_the_table_where_it_is():
    world_from_camera = look_at((-0.8, 0.0, 1.5), (0.0, 0.0, 0.7))
    simulator = KinectSimulator(
        [Surface(table_mesh((0.6, 0.8), height=0.7))], world_from_camera, SD_CAMERA
    )
    image = simulator.measure(np.random.default_rng(0))
    cloud = PointCloud(simulator.xyz(image))
    world = world_from_camera.apply(cloud.points)
    top = world[world[:, 2] > 0.68]
    assert len(top) > 0.9 * len(world)  # the rest is the table's front side
    assert top[:, 2].mean() == pytest.approx(0.7, abs=0.001)
    np.testing.assert_allclose(np.ptp(top[:, :2], axis=0), [0.6, 0.8], atol=0.02)
    # Upright: the image's up is the world's, its right is to the right of the view.
    assert world_from_camera.rotation[2, 1] < 0
    np.testing.assert_allclose(world_from_camera.rotation[:, 0], [0, -1, 0], atol=1e-12)


def test_refuses_what_makes_no_sense():
    with pytest.raises(ConfigError, match='no upright view'):
        look_at((0, 0, 1), (0, 0, 0))
    with pytest.raises(ConfigError, match='range'):
        SensorModel(min_range=2.0, max_range=1.0)
    with pytest.raises(ConfigError, match='angles'):
        SensorModel(max_incidence_rad=2.0)
