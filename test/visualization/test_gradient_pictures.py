import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.visualization import draw_gradients

POINTS = np.random.default_rng(0).uniform(0.2, 0.8, (2, 300, 3))
IMAGES = np.zeros((3, 2, 20, 20))


def dark_pixels(image):
    return int((image.max(axis=-1) < 80).sum())


def test_arrows_are_drawn_where_the_error_depends_on_points():
    still, moving = np.zeros_like(POINTS), np.ones_like(POINTS)
    without = draw_gradients(POINTS, IMAGES, {'name': still})
    with_arrows = draw_gradients(POINTS, IMAGES, {'name': moving})
    assert with_arrows.shape == without.shape
    assert dark_pixels(with_arrows) > dark_pixels(without) + 1000


def test_the_sign_of_the_images_gradient_is_its_colour():
    images = IMAGES.copy()
    images[0, 1, 5:15, 5:15] = 1.0
    red, blue = (
        draw_gradients(POINTS, sign * images, {'name': 0.0 * POINTS})[60:280, :300].mean((0, 1))
        for sign in (1.0, -1.0)
    )
    assert red[0] > red[2] + 10
    assert blue[2] > blue[0] + 10


def test_gradients_that_do_not_fit_are_refused():
    with pytest.raises(ConfigError, match='by points'):
        draw_gradients(POINTS, IMAGES, {'name': POINTS[:, :10]})
    with pytest.raises(ConfigError, match='by images'):
        draw_gradients(POINTS, IMAGES[:2], {'name': POINTS})
