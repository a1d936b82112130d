import dataclasses

import numpy as np
import pytest
import torch

from spatial_relations_ros.imitation.shape import Shape, shape_of


def test_a_mesh_gives_exact_distances(solids):
    shape = Shape(solids.box('box', (0.2, 0.1, 0.06), (0, 0, 0)))
    queries = np.array([[0, 0, 0], [0.2, 0, 0], [0, 0, 0.05], [0.1, 0, 0]], np.float32)
    np.testing.assert_allclose(shape.signed_distance(queries), [-0.03, 0.1, 0.02, 0.0], atol=1e-6)
    assert not shape.is_estimate
    np.testing.assert_allclose(shape.centre_of_mass, 0.0, atol=1e-6)


def test_the_grid_follows_the_exact_distance_and_continues_beyond_it(solids):
    shape = Shape(solids.cup('cup', 0.05, 0.12, (0, 0, 0)))
    rng = np.random.default_rng(0)
    queries = rng.uniform(-0.055, 0.055, (500, 3)).astype(np.float32)
    exact = shape.signed_distance(queries)
    grid = shape.field.sample(torch.from_numpy(queries)).numpy()
    assert np.abs(grid - exact).max() < 1.5 * shape.field.spacing
    far = torch.tensor([[0.5, 0.0, 0.0], [1.0, 0.0, 0.0]])
    distances = shape.field.sample(far).numpy()
    np.testing.assert_allclose(distances, [0.45, 0.95], atol=0.01)


def test_the_grid_has_a_gradient_that_points_outwards(solids):
    shape = Shape(solids.box('box', (0.1, 0.1, 0.1), (0, 0, 0)))
    query = torch.tensor([0.04, 0.01, 0.0], requires_grad=True)
    shape.field.sample(query).backward()
    np.testing.assert_allclose(query.grad.numpy(), [1.0, 0.0, 0.0], atol=0.05)


def test_a_cloud_alone_gives_an_estimate_that_keeps_openings_open(solids):
    cup = dataclasses.replace(solids.cup('cup', 0.05, 0.12, (0, 0, 0)), mesh=None)
    shape = Shape(cup)
    assert shape.is_estimate
    inside_cavity, above, in_floor = shape.signed_distance(
        np.array([[0, 0, 0], [0.05, 0, 0.12], [0, 0, -0.058]], np.float32)
    )
    cell = shape.field.spacing
    assert inside_cavity == pytest.approx(0.046, abs=1.5 * cell)
    assert above == pytest.approx(0.06, abs=1.5 * cell)
    assert in_floor < 0.5 * cell


def test_a_cloud_of_a_closed_box_is_solid(solids):
    box = dataclasses.replace(solids.box('box', (0.1, 0.1, 0.1), (0, 0, 0)), mesh=None)
    shape = Shape(box)
    middle, outside = shape.signed_distance(np.array([[0, 0, 0], [0.08, 0, 0]], np.float32))
    assert middle == pytest.approx(-0.05, abs=0.01)
    assert outside == pytest.approx(0.03, abs=0.01)


def test_a_mesh_with_a_hole_counts_as_a_cloud(solids):
    box = solids.box('box', (0.1, 0.1, 0.1), (0, 0, 0))
    torn = dataclasses.replace(box.mesh, triangles=box.mesh.triangles[1:])
    assert Shape(dataclasses.replace(box, mesh=torn)).is_estimate


def test_shapes_of_meshes_are_made_once(solids):
    box = solids.box('box', (0.1, 0.1, 0.1), (0, 0, 0))
    assert shape_of(box) is shape_of(box)
