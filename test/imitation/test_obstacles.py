"""Other things in the scene: how deep an object would reach into them."""

import dataclasses

import numpy as np
import pytest

from spatial_relations_ros.core import CloudSource, InvalidSceneError, Pose
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.imitation.contact import Body
from spatial_relations_ros.imitation.manipulation import (
    Obstacle,
    check_obstacles,
    obstacle_depths,
    without_strays,
)
from spatial_relations_ros.imitation.manipulation.obstacles import thinned
from spatial_relations_ros.imitation.shape import shape_of


def body_of(item):
    return Body(shape_of(item), item.world_from_object)


def face(x, size=0.2, spacing=0.003):
    """A wall as a camera sees it: one side only, a plane at x."""
    steps = np.arange(-size / 2, size / 2, spacing)
    y, z = np.meshgrid(steps, steps + size / 2)
    return np.stack([np.full(y.size, x), y.ravel(), z.ravel()], axis=1)


@pytest.fixture
def carton(solids):
    return solids.box('carton', (0.1, 0.1, 0.1), (0, 0, 0.05))


def test_overlap_with_a_cloud_is_told_in_millimetres(carton):
    touching = Obstacle.of_cloud(face(0.05))
    assert check_obstacles('carton', body_of(carton), [touching]).violations == ()
    inside = Obstacle.of_cloud(face(0.038))
    check = check_obstacles('carton', body_of(carton), [touching, inside])
    assert check.violations == ('carton would overlap an obstacle by 12 mm',)
    assert check.penetration == pytest.approx(0.012, abs=1e-3)


def test_overlap_with_an_object_is_told_by_its_name(carton, solids):
    jar = solids.box('jar', (0.1, 0.1, 0.1), (0.08, 0, 0.05))
    check = check_obstacles('carton', body_of(carton), [Obstacle.of_object(jar)])
    assert check.violations == ('carton would overlap jar by 20 mm',)
    beside = jar.moved_to(Pose(np.array([0.1005, 0, 0.05])))
    assert check_obstacles('carton', body_of(carton), [Obstacle.of_object(beside)]) == (
        dataclasses.replace(check, penetration=0.0, violations=())
    )


def test_within_a_large_object_is_within_though_no_surface_is_near(solids):
    small = solids.box('die', (0.02, 0.02, 0.02), (0, 0, 0.2))
    big = solids.box('crate', (0.4, 0.4, 0.4), (0, 0, 0.2))
    check = check_obstacles('die', body_of(small), [Obstacle.of_object(big)])
    assert 'die would overlap crate' in check.violations[0]
    # Of a live cloud only what is seen counts.
    seen = dataclasses.replace(big, mesh=None, source=CloudSource.OBSERVED)
    assert check_obstacles('die', body_of(small), [Obstacle.of_object(seen)]).violations == ()


def test_a_thin_wall_may_not_cut_through_a_cloud(solids):
    plate = solids.box('plate', (0.2, 0.2, 0.003), (0, 0, 0.1))
    check = check_obstacles('plate', body_of(plate), [Obstacle.of_cloud(face(0.0))])
    assert 'plate would cut into an obstacle' in check.violations[0]
    beside = Obstacle.of_cloud(face(0.101))
    assert check_obstacles('plate', body_of(plate), [beside]).violations == ()


def test_many_poses_at_once_agree_with_one_by_one(carton, solids):
    rng = np.random.default_rng(1)
    jar = solids.cup('jar', 0.05, 0.12, (0.12, 0.02, 0.06))
    obstacles = [Obstacle.of_cloud(face(0.1)), Obstacle.of_object(jar)]
    poses = [
        Pose.from_rotation(
            matrix_from_rotvec(rng.normal(scale=0.4, size=3)), rng.uniform(-0.12, 0.12, 3)
        )
        for _ in range(60)
    ]
    shape = shape_of(carton)
    depths = obstacle_depths(shape, poses, obstacles)
    exact = [check_obstacles('carton', Body(shape, pose), obstacles).penetration for pose in poses]
    assert (depths > 0.01).any()
    assert (depths == 0.0).any()
    is_deep = np.array(exact) > 0.008  # deeper than walls of the jar, which the grid misses
    np.testing.assert_allclose(depths[is_deep], np.array(exact)[is_deep], atol=0.003)


def test_poses_far_from_everything_are_clear(carton):
    far = [Pose(np.array([x, 0.0, 0.0])) for x in (5.0, -5.0)]
    depths = obstacle_depths(shape_of(carton), far, [Obstacle.of_cloud(face(0.0))])
    np.testing.assert_array_equal(depths, [0.0, 0.0])
    assert obstacle_depths(shape_of(carton), [], [Obstacle.of_cloud(face(0.0))]).shape == (0,)
    np.testing.assert_array_equal(obstacle_depths(shape_of(carton), far, []), [0.0, 0.0])


def test_far_from_the_worlds_origin_nothing_changes(carton):
    shift = np.array([4e5, -3e5, 20.0])
    moved = body_of(carton).shifted(shift)
    check = check_obstacles('carton', moved, [Obstacle.of_cloud(face(0.038) + shift)])
    assert check.penetration == pytest.approx(0.012, abs=1e-3)


def test_a_dense_cloud_is_thinned_to_a_point_a_cell():
    rng = np.random.default_rng(0)
    dense = rng.uniform(-0.02, 0.02, (100_000, 3))
    thin = thinned(dense)
    assert 900 < len(thin) <= 11**3
    cells = np.floor((thin - dense.min(axis=0)) / 0.004).astype(int)
    assert len(np.unique(cells, axis=0)) == len(thin)
    assert {tuple(point) for point in thin} <= {tuple(point) for point in dense}


def test_single_points_between_surfaces_are_noise():
    strays = np.array([[0.1, 0.0, 0.1], [0.2, 0.0, 0.1], [0.2, 0.0, 0.11]])
    wall = face(0.0)
    np.testing.assert_array_equal(without_strays(np.concatenate([strays, wall])), wall)
    assert len(without_strays(strays[:0])) == 0


def test_clouds_that_are_none_are_refused():
    with pytest.raises(InvalidSceneError, match='shape'):
        Obstacle.of_cloud(np.zeros((4, 2)))
    with pytest.raises(InvalidSceneError, match='none of its 2 points is finite'):
        Obstacle.of_cloud(np.full((2, 3), np.nan), 'shelf')
    holes = np.array([[0.0, 0, 0], [np.nan, 0, 0], [0, np.inf, 0]])
    assert len(Obstacle.of_cloud(holes).points) == 1
