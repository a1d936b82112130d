import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError, Pose
from spatial_relations_ros.visualization import Camera, frame_objects, frame_points
from spatial_relations_ros.visualization.camera import hidden_share


def test_projects_as_a_pinhole():
    # Optical frame equal to the world frame: z forward, x right, y down.
    camera = Camera(Pose.identity(), focal_length=100.0, width=101, height=51)
    pixels, depth = camera.project(np.array([[0.0, 0.0, 2.0], [0.2, -0.1, 2.0]]))
    assert pixels == pytest.approx(np.array([[50.0, 25.0], [60.0, 20.0]]))
    assert depth == pytest.approx([2.0, 2.0])


def test_rays_and_projection_are_inverse():
    rng = np.random.default_rng(1)
    camera = frame_points(rng.normal(size=(50, 3)), azimuth_rad=0.7, elevation_rad=0.4)
    pixels = rng.uniform([0, 0], [camera.width, camera.height], size=(20, 2))
    depths = rng.uniform(0.5, 3.0, size=20)
    world = camera.position + depths[:, None] * camera.ray_directions(pixels)
    again, depth = camera.project(world)
    assert again == pytest.approx(pixels, abs=1e-2)
    assert depth == pytest.approx(depths, rel=1e-5)


@pytest.mark.parametrize('size', [(800, 600), (300, 900)])
def test_framing_fills_the_picture_with_a_margin(size):
    width, height = size
    points = np.random.default_rng(2).uniform(-0.1, 0.1, size=(200, 3)) + [3.0, -2.0, 1.0]
    camera = frame_points(points, width=width, height=height)
    pixels, depth = camera.project(points)
    assert (depth > 0).all()
    used = np.ptp(pixels, axis=0) / [width, height]
    assert (pixels.min(axis=0) > 0).all()
    assert (pixels.max(axis=0) < [width, height]).all()
    assert used.max() > 0.8


def test_world_up_is_up_and_the_camera_looks_down():
    camera = frame_points(np.eye(3))
    low, _ = camera.project(np.array([0.3, 0.3, 0.0]))
    high, _ = camera.project(np.array([0.3, 0.3, 0.5]))
    assert high[1] < low[1]
    assert high[0] == pytest.approx(low[0], abs=30)
    assert camera.position[2] > 0.5


def test_looks_from_a_side_where_nothing_is_hidden(make_box):
    large = make_box('wall', (0.4, 0.02, 0.4), (0.0, 0.0, 0.2))
    small = make_box('cube', (0.1, 0.1, 0.1), (0.0, 0.15, 0.05))
    camera = frame_objects([[large, small]])
    azimuth = np.arctan2(*(camera.position - small.world_from_object.translation)[1::-1])
    preferred = hidden_share([large, small], np.radians(-62.0), np.radians(27.0))
    chosen = hidden_share([large, small], float(azimuth), np.radians(27.0))
    assert chosen < preferred


def test_one_camera_holds_before_and_after(make_box):
    before = make_box('cube', (0.1, 0.1, 0.1), (0.0, 0.0, 0.05))
    after = make_box('cube', (0.1, 0.1, 0.1), (0.7, 0.3, 0.4))
    camera = frame_objects([[before], [after]])
    for item in (before, after):
        pixels, _ = camera.project(item.world_points)
        assert (pixels > 0).all()
        assert (pixels < [camera.width, camera.height]).all()


def test_refuses_what_is_no_camera():
    with pytest.raises(ConfigError):
        Camera(Pose.identity(), focal_length=0.0)
    with pytest.raises(ConfigError):
        frame_objects([])
