"""Straight ways into targets."""

import numpy as np
import pytest
from manifold3d import Manifold

from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.imitation.contact import Body
from spatial_relations_ros.imitation.manipulation import Obstacle
from spatial_relations_ros.imitation.manipulation.approach import find_approach
from spatial_relations_ros.imitation.shape import shape_of

LENGTH = 0.1


def body_of(item):
    return Body(shape_of(item), item.world_from_object)


def direction(approach, target):
    return (approach.pose.translation - target.pose.translation) / LENGTH


@pytest.fixture
def die(solids):
    return body_of(solids.box('die', (0.03, 0.03, 0.03), (0, 0, 0)))


def lying_cup(solids):
    """Opens along +x, its lowest inner point at z = 0.004."""
    outer = Manifold.cylinder(0.12, 0.05, 0.05, 64, True)
    inner = Manifold.cylinder(0.12, 0.046, 0.046, 64, True)
    cup = (outer - inner.translate((0, 0, 0.004))).rotate((0, 90, 0))
    return body_of(solids.of('cup', cup, (0, 0, 0.05)))


def test_onto_something_is_approached_from_above(solids, die):
    plate = body_of(solids.box('plate', (0.2, 0.2, 0.02), (0, 0, 0.01)))
    target = die.shifted(np.array([0.02, 0.0, 0.0352]))
    approach = find_approach(target, [plate], [], LENGTH)
    assert approach.is_clear
    np.testing.assert_allclose(direction(approach, target), [0, 0, 1], atol=1e-9)
    np.testing.assert_array_equal(approach.pose.quat_wxyz, target.pose.quat_wxyz)


def test_into_a_standing_cup_is_approached_from_above_though_it_fits_tightly(solids):
    cup = body_of(solids.cup('cup', 0.05, 0.12, (0, 0, 0.06)))
    pin = Manifold.cylinder(0.1, 0.0455, 0.0455, 64, True)  # half a millimetre all around
    target = body_of(solids.of('pin', pin, (0, 0, 0.056)))
    approach = find_approach(target, [cup], [], LENGTH)
    assert approach.is_clear
    assert direction(approach, target)[2] == pytest.approx(1.0)


def test_bodies_that_overlap_a_little_slide_out_of_each_other(solids, die):
    plate = body_of(solids.box('plate', (0.2, 0.2, 0.02), (0, 0, 0.01)))
    wall = body_of(solids.box('wall', (0.02, 0.2, 0.2), (0.023, 0, 0.1)))
    target = die.shifted(np.array([0.0, 0.0, 0.033]))  # 2 mm into both
    approach = find_approach(target, [plate, wall], [], LENGTH)
    assert approach.is_clear
    assert direction(approach, target)[2] == pytest.approx(1.0)


def test_into_a_lying_container_leads_along_its_opening(solids, die):
    cup = lying_cup(solids)
    target = die.shifted(np.array([-0.02, 0.0, 0.024]))
    approach = find_approach(target, [cup], [], LENGTH)
    assert approach.is_clear
    assert direction(approach, target)[0] > 0.9
    assert direction(approach, target)[2] >= 0.0


def test_under_an_overhang_leads_sideways(solids, die):
    table = Manifold.cube((0.3, 0.3, 0.01), True).translate((0, 0, 0.12)) + Manifold.cube(
        (0.02, 0.02, 0.12), True
    ).translate((0, 0, 0.06))
    stand = body_of(solids.of('stand', table, (0, 0, 0)))
    target = die.shifted(np.array([0.12, 0.0, 0.0152]))
    approach = find_approach(target, [stand], [], LENGTH)
    assert approach.is_clear
    assert direction(approach, target)[0] > 0.5


def test_obstacles_block_the_way_too(solids, die):
    shelf = body_of(solids.box('shelf', (0.2, 0.2, 0.02), (0, 0, 0.01)))
    target = die.shifted(np.array([0.0, 0.0, 0.0352]))
    grid = np.arange(-0.05, 0.05, 0.003)
    x, y = np.meshgrid(grid, grid)
    lid = np.stack([x.ravel(), y.ravel(), np.full(x.size, 0.08)], axis=1)
    for obstacle in (
        Obstacle.of_cloud(lid),
        Obstacle.of_object(solids.box('lid', (0.1, 0.1, 0.003), (0, 0, 0.08))),
    ):
        approach = find_approach(target, [shelf], [obstacle], LENGTH)
        assert approach.is_clear
        assert direction(approach, target)[2] < 0.9
    # What is farther up than the way is long does not matter.
    high = Obstacle.of_cloud(lid + [0, 0, 0.1])
    assert direction(find_approach(target, [shelf], [high], LENGTH), target)[2] == 1.0


def test_where_nothing_leads_it_is_said(solids, die):
    outer = Manifold.cube((0.2, 0.2, 0.2), True)
    box = body_of(solids.of('box', outer - Manifold.cube((0.1, 0.1, 0.1), True), (0, 0, 0.1)))
    target = die.shifted(np.array([0.0, 0.0, 0.0652]))
    approach = find_approach(target, [box], [], LENGTH)
    assert not approach.is_clear
    np.testing.assert_allclose(direction(approach, target), [0, 0, 1], atol=1e-9)


def test_a_leaning_board_comes_straight_down_or_off_its_support(solids):
    tilt = matrix_from_rotvec(np.array([0.0, -np.deg2rad(20.0), 0.0]))
    lean = Manifold.cube((0.01, 0.1, 0.2), True)
    board = solids.of('board', lean, (0, 0, 0))
    height = 0.5 * float(np.abs(tilt[2]) @ [0.01, 0.1, 0.2])
    pose = board.world_from_object.from_rotation(tilt, [0.0, 0.0, height])
    target = body_of(board.moved_to(pose))
    wall = body_of(solids.box('wall', (0.1, 0.2, 0.1), (-0.0862, 0, 0.05)))
    approach = find_approach(target, [wall], [], LENGTH)
    assert approach.is_clear
    assert direction(approach, target)[0] > -1e-6
