"""The gradients of rho: what each promises, and degenerate clouds."""

import dataclasses
import itertools

import numpy as np
import pytest
import torch

from spatial_relations_ros.core import ConfigError, InvalidSceneError
from spatial_relations_ros.projection import (
    GRADIENTS,
    ProjectionConfig,
    coarse_to_fine,
    fit_unit_cube,
    project,
)
from spatial_relations_ros.projection.depth_images import _Projection
from spatial_relations_ros.projection.pixel_gradients import _at_nearest
from spatial_relations_ros.projection.planes import depths, pixel_indices

CONFIG = ProjectionConfig(image_size=16, margin_px=2.0, splat_px=3)


def point_gradient(points, config, weights):
    points = points.detach().clone().requires_grad_(True)
    (gradient,) = torch.autograd.grad((project(points, config) * weights).sum(), points)
    return gradient


def random_scene(num_points=40, size=16, seed=0):
    generator = torch.Generator().manual_seed(seed)
    points = torch.randn(1, 2, num_points, 3, generator=generator, dtype=torch.float64)
    weights = torch.randn(1, 3, 2, size, size, generator=generator, dtype=torch.float64)
    return points, weights


@pytest.mark.parametrize('gradient', GRADIENTS)
@pytest.mark.parametrize(
    'points',
    [
        torch.zeros(1, 2, 30, 3),
        torch.ones(1, 2, 1, 3),
        torch.tensor([[[[0.0, 0, 0]], [[0.1, 0.2, 0.3]]]]),
        torch.rand(1, 1, 50, 3).repeat(1, 2, 1, 1),
        torch.rand(1, 2, 50, 3) * torch.tensor([1.0, 1.0, 0.0]),
        torch.cat([torch.rand(1, 1, 50, 3) * 1e-3, torch.rand(1, 1, 50, 3) * 1e3], dim=1),
    ],
    ids=['all in one place', 'one point', 'two points', 'identical', 'flat', 'tiny and huge'],
)
def test_degenerate_clouds_have_finite_gradients(points, gradient):
    config = dataclasses.replace(CONFIG, gradient=gradient)
    assert torch.isfinite(project(points, config)).all()
    weights = torch.randn(1, 3, 2, 16, 16, generator=torch.Generator().manual_seed(0))
    assert torch.isfinite(point_gradient(points, config, weights)).all()


@pytest.mark.parametrize('gradient', GRADIENTS)
def test_a_cloud_without_points_is_refused(gradient):
    with pytest.raises(InvalidSceneError, match='at least 1'):
        project(torch.zeros(1, 2, 0, 3), dataclasses.replace(CONFIG, gradient=gradient))


@pytest.mark.parametrize('gradient', GRADIENTS)
def test_images_and_gradients_repeat_themselves_to_the_bit(gradient):
    config = dataclasses.replace(CONFIG, gradient=gradient)
    points, weights = (tensor.float() for tensor in random_scene(500))
    assert torch.equal(project(points, config), project(points, config))
    first = point_gradient(points, config, weights)
    assert first.abs().max() > 0.0
    assert torch.equal(first, point_gradient(points, config, weights))


@pytest.mark.parametrize('gradient', GRADIENTS)
def test_a_scene_in_a_batch_has_the_gradient_that_it_has_alone(gradient):
    config = dataclasses.replace(CONFIG, gradient=gradient)
    scenes = [random_scene(seed=seed) for seed in range(3)]
    points, weights = (torch.cat(parts) for parts in zip(*scenes, strict=True))
    together = point_gradient(points, config, weights)
    alone = torch.cat([point_gradient(p, config, w) for p, w in scenes])
    torch.testing.assert_close(together, alone)


def test_an_unknown_gradient_names_the_known_ones():
    with pytest.raises(ConfigError, match=', '.join(map(repr, GRADIENTS))):
        ProjectionConfig(gradient='hard')
    with pytest.raises(ConfigError, match='soft_width_px'):
        ProjectionConfig(soft_width_px=0.0)


def naive_released(unit, images, grad, size):
    """Gradient by points, one scene without splatting, plane by plane and pixel by pixel."""
    column_of, row_of = (0, 0, 1), (1, 2, 2)  # world axes
    looks_along, sign = (2, 1, 0), (-1.0, 1.0, 1.0)
    result = np.zeros_like(unit)
    for channel in range(2):
        pixels = np.floor(unit[channel] * size).astype(int)
        total = [sign[p] * 100.0 * grad[p, channel] for p in range(3)]
        for plane in range(3):
            slope_x, slope_y = np.zeros((2, size, size))
            for r, c, dr, dc in np.ndindex(size, size, 5, 5):
                rr, cc, dr, dc = r + dr - 2, c + dc - 2, dr - 2, dc - 2
                if (dr, dc) != (0, 0) and 0 <= rr < size and 0 <= cc < size:
                    value = grad[plane, channel, rr, cc] / (dr**2 + dc**2)
                    slope_x[r, c] += dc * value
                    slope_y[r, c] += dr * value
            for r, c in np.argwhere(images[plane, channel] > 0):
                # Moving along the column axis: lands in the plane that looks along it, at all
                # pixels whose coordinate along the row axis is r; and the other way round.
                for axis, kept_axis, kept, slope in (
                    (column_of[plane], row_of[plane], r, slope_x[r, c]),
                    (row_of[plane], column_of[plane], c, slope_y[r, c]),
                ):
                    target = looks_along.index(axis)
                    if column_of[target] == kept_axis:
                        total[target][:, kept] += size * slope
                    else:
                        total[target][kept, :] += size * slope
        for plane in range(3):
            axis = looks_along[plane]
            depth = 1.0 - unit[channel][:, 2] if axis == 2 else unit[channel][:, axis]
            for r, c in {(p[row_of[plane]], p[column_of[plane]]) for p in pixels}:
                here = np.flatnonzero(
                    (pixels[:, row_of[plane]] == r) & (pixels[:, column_of[plane]] == c)
                )
                nearest = here[depth[here].argmin()]
                result[channel][nearest, axis] += total[plane][r, c]
    return result


def test_the_released_gradient_equals_a_naive_loop():
    config = dataclasses.replace(CONFIG, gradient='released', splat_px=1)
    points, weights = random_scene(60)
    unit = fit_unit_cube(points, 2.0 / 16).requires_grad_(True)
    images = project(points, config)
    (found,) = torch.autograd.grad((_Projection.apply(unit, config) * weights).sum(), unit)
    expected = naive_released(
        unit.detach().numpy()[0], images.numpy()[0], weights.numpy()[0], config.image_size
    )
    np.testing.assert_allclose(found.numpy()[0], expected, atol=1e-9)


def test_splatted_pixels_give_the_released_gradient_to_the_points_that_they_show():
    """With larger squares nothing is lost: what pixels hold arrives at points."""
    points, weights = random_scene(60)
    config = dataclasses.replace(CONFIG, gradient='released')
    unit = fit_unit_cube(points, 2.0 / 16)
    images = project(points, config)
    values = weights * (images > 0)
    taken = _at_nearest(values, images, pixel_indices(unit, 16), depths(unit), config)
    torch.testing.assert_close(taken.sum(dim=-1), values.sum(dim=(-2, -1)))


def test_the_soft_gradient_is_the_derivative_of_the_soft_images():
    config = dataclasses.replace(CONFIG, gradient='soft')
    points, weights = random_scene()
    gradient = point_gradient(points, config, weights)
    for seed in range(4):
        direction = torch.randn(
            points.shape, generator=torch.Generator().manual_seed(9 + seed), dtype=torch.float64
        )
        after, before = (
            (project(points + step * direction, config) * weights).sum() for step in (1e-6, -1e-6)
        )
        numeric = float(after - before) / 2e-6
        assert float((gradient * direction).sum()) == pytest.approx(numeric, rel=1e-3)


def test_soft_images_of_dense_clouds_are_close_to_the_hard_ones():
    generator = torch.Generator().manual_seed(1)
    points = torch.rand(1, 2, 20000, 3, generator=generator)
    config = ProjectionConfig(image_size=32, margin_px=4.0)
    hard = project(points, config)
    fine, coarse = (
        project(points, dataclasses.replace(config, gradient='soft', soft_width_px=width))
        for width in (0.5, 3.0)
    )
    inside = torch.zeros(32, 32, dtype=torch.bool)
    inside[8:24, 8:24] = True
    assert (fine - hard)[..., inside].abs().max() < 12.0  # of 100 to 200
    assert (fine[hard == 0]).mean() < 10.0
    assert (fine - hard).abs().mean() < (coarse - hard).abs().mean()


def test_straight_through_shows_hard_images_with_a_soft_derivative():
    points, weights = random_scene()
    hard, through, soft = (
        dataclasses.replace(CONFIG, gradient=name)
        for name in ('silhouette', 'straight_through', 'soft')
    )
    assert torch.equal(project(points, through), project(points, hard))
    torch.testing.assert_close(
        point_gradient(points, through, weights), point_gradient(points, soft, weights)
    )


def test_the_width_shrinks_from_coarse_to_fine():
    widths = [coarse_to_fine(step / 10, coarse_px=4.0, fine_px=1.0) for step in range(11)]
    assert widths[0] == pytest.approx(4.0)
    assert widths[5] == pytest.approx(2.0)
    assert widths[10] == pytest.approx(1.0)
    assert all(after < before for before, after in itertools.pairwise(widths))
    assert coarse_to_fine(2.0) == coarse_to_fine(1.0)
