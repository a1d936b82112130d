import math

import numpy as np
import pytest

from spatial_relations_ros.core import Pose
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.imitation.contact import (
    CONTACT_GAP,
    Body,
    drop,
    overlap,
    reach_through,
    separate,
    settle,
    travel_to_contact,
)
from spatial_relations_ros.imitation.shape import shape_of


def body(item):
    return Body(shape_of(item), item.world_from_object)


def bottom(placed):
    return placed.world_points[:, 2].min()


def test_travel_between_two_boxes(solids):
    left = body(solids.box('left', (0.1, 0.1, 0.1), (0, 0, 0.05)))
    right = body(solids.box('right', (0.1, 0.1, 0.1), (0.35, 0.02, 0.05)))
    travel = travel_to_contact(left, right, np.array([1.0, 0, 0]), np.array([[0.0, 0, 0]]))
    assert travel[0] == pytest.approx(0.25, abs=1e-4)
    away = travel_to_contact(left, right, np.array([-1.0, 0, 0]), np.array([[0.0, 0, 0]]))
    assert math.isinf(away[0])


def test_a_box_drops_onto_a_box(solids):
    base = body(solids.box('base', (0.2, 0.2, 0.05), (0, 0, 0.025)))
    falling = body(solids.box('box', (0.05, 0.05, 0.1), (0.05, 0, 0.5)))
    assert bottom(drop(falling, base, 0.0)) == pytest.approx(0.05 + CONTACT_GAP, abs=1e-4)


def test_a_box_drops_into_a_cup_with_little_room(solids):
    cup = body(solids.cup('cup', 0.05, 0.1, (0, 0, 0.05)))
    # The cup's inner radius is 46 mm, half the box's diagonal 42 mm.
    falling = body(solids.box('box', (0.06, 0.06, 0.06), (0, 0, 0.3)))
    assert bottom(drop(falling, cup, 0.0)) == pytest.approx(0.004 + CONTACT_GAP, abs=1e-4)


def test_a_box_beside_the_cup_drops_to_the_table(solids):
    cup = body(solids.cup('cup', 0.05, 0.1, (0, 0, 0.05)))
    falling = body(solids.box('box', (0.06, 0.06, 0.06), (0.2, 0, 0.3)))
    assert bottom(drop(falling, cup, 0.0)) == pytest.approx(0.0, abs=1e-6)


def test_overlap_is_the_depth_and_the_way_out(solids):
    base = body(solids.box('base', (0.2, 0.2, 0.2), (0, 0, 0.1)))
    sunk = body(solids.box('box', (0.04, 0.04, 0.04), (0, 0, 0.21)))
    depth, outward = overlap(sunk, base)
    assert depth == pytest.approx(0.01, abs=1e-3)
    np.testing.assert_allclose(outward, [0, 0, 1], atol=0.05)
    clear = body(solids.box('box', (0.04, 0.04, 0.04), (0, 0, 0.23)))
    assert overlap(clear, base)[0] == 0.0


def test_separation_takes_the_short_way(solids):
    base = body(solids.box('base', (0.2, 0.2, 0.2), (0, 0, 0.1)))
    sunk = body(solids.box('box', (0.04, 0.04, 0.04), (0.11, 0, 0.1)))
    freed = separate(sunk, base)
    assert overlap(freed, base)[0] <= CONTACT_GAP
    assert freed.pose.translation[0] == pytest.approx(0.12, abs=2e-3)
    assert freed.pose.translation[2] == pytest.approx(0.1, abs=2e-3)


def test_settling_lifts_out_of_the_table_and_lets_down(solids):
    base = body(solids.box('base', (0.1, 0.1, 0.1), (0, 0, 0.05)))
    tilted = Pose.from_rotation(matrix_from_rotvec(np.array([0, 0.3, 0])), [0.3, 0, 0.0])
    item = solids.box('box', (0.06, 0.06, 0.06), (0, 0, 0)).moved_to(tilted)
    assert bottom(settle(body(item), base, 0.0)) == pytest.approx(0.0, abs=1e-6)


def test_crossing_thin_walls_are_found_though_they_are_hardly_deep(solids):
    cup = body(solids.cup('cup', 0.05, 0.1, (0, 0, 0.05), wall=0.002))
    across = body(solids.cup('other', 0.05, 0.1, (0.06, 0, 0.08), wall=0.002))
    assert overlap(across, cup)[0] < 0.003
    assert reach_through(across, cup) > 0.01
    beside = body(solids.cup('other', 0.05, 0.1, (0.1005, 0, 0.08), wall=0.002))
    assert reach_through(beside, cup) == 0.0
    nested = body(solids.cup('other', 0.04, 0.1, (0, 0, 0.06), wall=0.002))
    assert reach_through(nested, cup) == 0.0
