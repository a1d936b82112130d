import matplotlib
import numpy as np
import pytest
from matplotlib import pyplot

from spatial_relations_ros.visualization import draw_distance_curve
from spatial_relations_ros.visualization.curves import draw_loss_curve
from spatial_relations_ros.visualization.palette import BASE_COLOUR, as_bytes


def curve_pixels(image):
    return (np.abs(image.astype(int) - as_bytes(BASE_COLOUR)).sum(axis=-1) < 12).nonzero()


def test_a_falling_history_falls_in_the_picture():
    image = draw_distance_curve(np.linspace(2.0, 0.1, 30), width=400, height=300)
    assert image.shape == (300, 400, 3)
    rows, columns = curve_pixels(image)
    left, right = rows[columns < 150].mean(), rows[columns > 300].mean()
    assert right > left + 60


def test_scale_starts_at_zero():
    # Values that differ little must not look like a steep fall.
    rows, _ = curve_pixels(draw_distance_curve([1.0, 0.99, 0.98], width=400, height=300))
    assert np.ptp(rows) < 40


@pytest.mark.parametrize('history', [[], [float('nan')] * 4, [0.0, 0.0], [1.0]])
def test_odd_histories_are_drawn(history):
    image = draw_distance_curve(history, width=300, height=200)
    assert image.shape == (200, 300, 3)
    assert len(np.unique(image)) > 5


def test_leaves_matplotlib_alone():
    before = dict(matplotlib.rcParams)
    draw_distance_curve([1.0, 0.5], width=200, height=150)
    assert dict(matplotlib.rcParams) == before
    assert pyplot.get_fignums() == []


def test_the_running_mean_of_a_noisy_loss_is_drawn_over_it():
    noisy = np.linspace(1.0, 0.2, 400) + np.random.default_rng(0).normal(0.0, 0.05, 400)
    image = draw_loss_curve(noisy, width=400, height=300)
    assert image.shape == (300, 400, 3)
    rows, columns = curve_pixels(image)
    left, right = rows[columns < 150].mean(), rows[columns > 300].mean()
    assert right > left + 60


@pytest.mark.parametrize('losses', [[], [0.5], [0.0, 0.0]])
def test_short_runs_are_drawn(losses):
    assert draw_loss_curve(losses, width=300, height=200).shape == (200, 300, 3)
