"""rho: against a naive loop; its gradient: against finite differences of smooth errors."""

import dataclasses
import math

import numpy as np
import pytest
import roma
import torch

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.projection import (
    GRADIENTS,
    ProjectionConfig,
    fit_unit_cube,
    project,
    resample_points,
    sobel_kernel,
)

# Columns, rows and depth of the three planes, as in the paper's figure 3.
PLANES = [
    (lambda p: p[0], lambda p: p[1], lambda p: 1.0 - p[2]),
    (lambda p: p[0], lambda p: p[2], lambda p: p[1]),
    (lambda p: p[1], lambda p: p[2], lambda p: p[0]),
]


def naive_projection(unit, config):
    size, radius = config.image_size, config.splat_px // 2
    image = np.zeros((3, 2, size, size))
    for plane, (column, row, depth) in enumerate(PLANES):
        for channel in range(2):
            for point in unit[channel]:
                value = 100.0 * depth(point) + 100.0
                u = min(max(math.floor(column(point) * size), 0), size - 1)
                v = min(max(math.floor(row(point) * size), 0), size - 1)
                for r in range(max(v - radius, 0), min(v + radius, size - 1) + 1):
                    for c in range(max(u - radius, 0), min(u + radius, size - 1) + 1):
                        old = image[plane, channel, r, c]
                        if old == 0 or value < old:
                            image[plane, channel, r, c] = value
    return image


@pytest.mark.parametrize('splat_px', [1, 3, 5])
def test_images_equal_a_naive_loop(splat_px):
    generator = torch.Generator().manual_seed(splat_px)
    points = torch.randn(2, 2, 60, 3, generator=generator, dtype=torch.float64)
    config = ProjectionConfig(image_size=20, margin_px=1.0, splat_px=splat_px)
    images = project(points, config)
    unit = fit_unit_cube(points, 1.0 / 20)
    for scene in range(2):
        np.testing.assert_allclose(
            images[scene].numpy(), naive_projection(unit[scene].numpy(), config), rtol=1e-12
        )


def test_pixel_values_are_zero_or_between_bias_and_twice_the_bias():
    images = project(torch.randn(3, 2, 200, 3), ProjectionConfig(image_size=32))
    occupied = images[images > 0]
    assert occupied.min() >= 100.0
    assert occupied.max() <= 200.0
    assert (images == 0).any()


def test_a_scene_looks_in_a_large_batch_as_it_does_alone():
    points = torch.randn(19, 2, 50, 3)
    config = ProjectionConfig(image_size=24)
    alone = torch.cat([project(scene[None], config) for scene in points])
    assert torch.equal(project(points, config), alone)


def test_images_do_not_depend_on_units_or_on_where_the_scene_is():
    points = torch.randn(2, 2, 300, 3, dtype=torch.float64)
    moved = 1000.0 * points + torch.tensor([5.0, -7.0, 30.0], dtype=torch.float64)
    # With a whole number of pixels as margin the outermost points lie between two pixels.
    config = ProjectionConfig(image_size=48, margin_px=1.3)
    assert torch.allclose(project(points, config), project(moved, config), atol=1e-6)


@pytest.mark.parametrize('gradient', GRADIENTS)
def test_a_common_shift_has_no_gradient(gradient):
    points = torch.randn(2, 2, 200, 3, dtype=torch.float64)
    shift = torch.zeros(2, 1, 1, 3, dtype=torch.float64, requires_grad=True)
    images = project(points + shift, ProjectionConfig(image_size=32, gradient=gradient))
    (images * torch.randn_like(images)).sum().backward()
    per_point = images.abs().sum()
    assert shift.grad.abs().max() < 1e-12 * per_point


def cube_cloud(size, centre, num=6000, seed=0):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-0.5, 0.5, (num, 3))
    axis = rng.integers(0, 3, num)
    points[np.arange(num), axis] = rng.choice([-0.5, 0.5], num)
    return torch.from_numpy(points * size + np.asarray(centre))


def smooth_error(images, seed=1):
    """A weighted mean of the images whose weights vary slowly over pixels."""
    size = images.shape[-1]
    ticks = torch.linspace(-1, 1, size, dtype=images.dtype)
    y, x = torch.meshgrid(ticks, ticks, indexing='ij')
    generator = torch.Generator().manual_seed(seed)
    waves = torch.randn(3, 2, 4, generator=generator, dtype=images.dtype)
    terms = torch.stack([x, y, torch.sin(2 * x + y), torch.cos(x - 2 * y)])
    weights = torch.einsum('pck,khw->pchw', waves, terms)
    return (images * weights).sum() / images.numel()


FRAME = torch.tensor([[-1.0, -1, -1], [1, 1, 1]], dtype=torch.float64)
CONFIG = ProjectionConfig(image_size=100, margin_px=2, splat_px=3)


def scene_with_moved_cube(offset, rotvec):
    """A cube that moves in a scene whose extent two far corner points of the base fix."""
    base = torch.cat([cube_cloud([0.5, 0.6, 0.4], [-0.5, -0.4, -0.5]), FRAME])
    cube = cube_cloud([0.5, 0.7, 0.6], [0, 0, 0], num=len(base))
    turned = cube @ roma.rotvec_to_rotmat(rotvec).T
    return torch.stack([base, turned + torch.tensor([0.3, 0.2, 0.1]) + offset])[None]


def numeric_derivative(error, steps):
    """Mean central difference; steps of several pixels (0.02 each) smooth the rounding."""
    return np.mean([(error(step) - error(-step)) / (2.0 * step) for step in steps])


def derivatives(axis, seed, gradient, turning):
    """Numeric and analytic derivative for moving or turning the cube along one axis.

    The cube is turned already when it turns, so that its edges are not aligned with pixels.
    """
    config = dataclasses.replace(CONFIG, gradient=gradient)

    def points(amount):
        offset, rotvec = torch.zeros(2, 3, dtype=torch.float64)
        if turning:
            rotvec[axis] = 0.35
            return scene_with_moved_cube(offset, rotvec + amount * torch.eye(3)[axis])
        return scene_with_moved_cube(offset + amount * torch.eye(3)[axis], rotvec)

    numeric = numeric_derivative(
        lambda step: float(smooth_error(project(points(step), config), seed)),
        [0.1, 0.15, 0.2] if turning else [0.08, 0.12, 0.16],
    )
    amount = torch.zeros((), dtype=torch.float64, requires_grad=True)
    smooth_error(project(points(amount), config), seed).backward()
    return numeric, float(amount.grad)


@pytest.mark.parametrize('gradient', ['silhouette', 'sobel'])
@pytest.mark.parametrize('axis', range(3))
def test_the_gradient_of_a_shift_equals_finite_differences(axis, gradient):
    pairs = np.array([derivatives(axis, seed, gradient, turning=False) for seed in range(4)])
    numeric, analytic = pairs.T
    assert np.linalg.norm(analytic - numeric) < 0.12 * np.linalg.norm(numeric)


@pytest.mark.parametrize('axis', range(3))
def test_the_gradient_of_a_turn_equals_finite_differences(axis):
    pairs = np.array([derivatives(axis, seed, 'silhouette', turning=True) for seed in range(4)])
    numeric, analytic = pairs.T
    assert np.linalg.norm(analytic - numeric) < 0.3 * np.linalg.norm(numeric)
    assert (np.sign(analytic) == np.sign(numeric))[np.abs(numeric) > 0.3].all()


def test_the_sobel_gradient_turns_a_plate_about_the_viewing_axis():
    """A flat object has one layer of points, so there a turn about z is seen by ``sobel`` too."""
    rng = np.random.default_rng(0)
    plate = torch.from_numpy(rng.uniform(-0.5, 0.5, (6000, 3)) * [0.9, 0.3, 0.0])
    base = torch.cat([cube_cloud([0.2, 0.2, 0.2], [0, 0, -0.8], num=5998), FRAME])
    config = dataclasses.replace(CONFIG, gradient='sobel')
    size = config.image_size
    ticks = torch.linspace(-1, 1, size, dtype=torch.float64)
    weights = ticks[:, None] * ticks[None, :]  # torque about z only

    def error(angle):
        turn = roma.rotvec_to_rotmat(torch.eye(3, dtype=torch.float64)[2] * angle)
        images = project(torch.stack([base, plate @ turn.T])[None], config)
        return (images[0, 0, 1] * weights).sum() / size**2

    numeric = numeric_derivative(lambda step: float(error(step)), [0.1, 0.15, 0.2])
    angle = torch.zeros((), dtype=torch.float64, requires_grad=True)
    error(angle).backward()
    assert float(angle.grad) == pytest.approx(numeric, rel=0.15)


def test_the_kernel_measures_the_slope_of_a_ramp():
    for size in (3, 5, 7):
        kernel = sobel_kernel(size, dtype=torch.float64)
        ramp = torch.arange(size, dtype=torch.float64)[None, :].expand(size, size)
        assert float((kernel * ramp).sum()) == pytest.approx(1.0)
        assert float((kernel * ramp.T).sum()) == pytest.approx(0.0, abs=1e-12)


def test_resampling_repeats_itself_and_keeps_the_points():
    points = np.random.default_rng(0).normal(size=(50, 3)).astype(np.float32)
    few, many = resample_points(points, 20), resample_points(points, 120)
    np.testing.assert_array_equal(few, resample_points(points, 20))
    assert len(few) == 20
    assert {tuple(p) for p in many} == {tuple(p) for p in points}


@pytest.mark.parametrize(
    'settings',
    [
        {'image_size': 4},
        {'splat_px': 2},
        {'sobel_size': 1},
        {'margin_px': 60.0},
        {'gradient': 'x'},
    ],
)
def test_impossible_settings_are_refused(settings):
    with pytest.raises(ConfigError):
        ProjectionConfig(**settings)
