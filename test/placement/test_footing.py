"""How feet lie on supports, and how far things lean, on boxes whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spatial_relations_ros.core import Relation
from spatial_relations_ros.datasets.generator import measure
from spatial_relations_ros.datasets.objects.model_of_solid import model_of_solid
from spatial_relations_ros.datasets.objects.solids import NUM_SEGMENTS, box, solid_of_wall
from spatial_relations_ros.placement.body import Body, Placed
from spatial_relations_ros.placement.footing import Footing
from spatial_relations_ros.placement.leaning import lean_angle_rad
from spatial_relations_ros.placement.resting import about_axis, about_z

LARGE, SMALL = 0.2, 0.1


def body_of(size) -> Body:
    return Body.of(model_of_solid('test', box(size), {}))


TABLE_TOP, FOOT = body_of((LARGE, LARGE, 0.05)), body_of((SMALL, SMALL, 0.05))
HALF_A_FACET = about_z(np.pi / NUM_SEGMENTS)
POLE = body_of((0.03, 0.03, 0.05))


def stacked(lower: Body, upper: Body, x: float, *, turn: float = 0.0) -> tuple[Placed, Placed]:
    """Two boxes of 5 cm, one on the other, shifted and turned."""
    return (
        Placed(lower, np.eye(3), np.array([0.0, 0.0, 0.025])),
        Placed(upper, about_z(turn), np.array([x, 0.0, 0.075])),
    )


@settings(max_examples=25, deadline=None)
@given(x=st.floats(-0.14, 0.14))
def test_overhang_is_the_shift_beyond_flush(x):
    footing = Footing.of(*stacked(TABLE_TOP, FOOT, x))
    assert footing.overhang.max() == pytest.approx(abs(x) - (LARGE - SMALL) / 2, abs=1e-6)
    assert footing.offset.max() == pytest.approx(abs(x), abs=1e-6)
    assert footing.overhang_share == pytest.approx((abs(x) - 0.05) / SMALL, abs=1e-5)


@settings(max_examples=40, deadline=None)
@given(x=st.floats(-0.13, 0.13), turn=st.floats(0.0, np.pi))
def test_no_place_is_both_on_top_and_at_the_edge(x, turn):
    pair = stacked(TABLE_TOP, FOOT, x, turn=turn)
    footing = Footing.of(*pair)
    assert footing.on_top_reason() or footing.edge_reason()


@pytest.mark.parametrize(
    ('x', 'on_top', 'edge'),
    [
        (0.0, '', 'hardly over the edge'),
        (0.03, '', 'hardly over the edge'),
        (0.05, 'near the edge', 'hardly over the edge'),
        (0.065, 'near the edge', 'hardly over the edge'),
        (0.09, 'near the edge', ''),
    ],
)
def test_between_on_top_and_at_the_edge_is_a_gap(x, on_top, edge):
    footing = Footing.of(*stacked(TABLE_TOP, FOOT, x))
    assert footing.on_top_reason() == on_top
    assert footing.edge_reason() == edge


def test_a_large_box_on_a_pole_is_on_top_only_when_centred():
    assert Footing.of(*stacked(POLE, FOOT, 0.001)).on_top_reason() == ''
    shifted = Footing.of(*stacked(POLE, FOOT, 0.012))
    assert shifted.on_top_reason() == 'near the edge'
    assert shifted.edge_reason() == 'over both edges'


@pytest.mark.parametrize('angle_deg', [0.0, 5.0, 30.0, 44.0, 60.0, 90.0])
def test_a_box_leans_by_the_angle_to_its_nearest_side(angle_deg):
    rotation = about_axis(np.array([1.0, 0.0, 0.0]), np.deg2rad(angle_deg)) @ about_z(0.7)
    turned_first = about_z(0.7) @ about_axis(np.array([1.0, 0.0, 0.0]), np.deg2rad(angle_deg))
    placed = Placed(FOOT, turned_first, np.zeros(3))
    expected = min(angle_deg, 90.0 - angle_deg)
    assert np.rad2deg(lean_angle_rad(placed)) == pytest.approx(expected, abs=1e-3)
    # A turn about the box's own axis first gives an edge or a corner below, never less lean.
    assert lean_angle_rad(Placed(FOOT, rotation, np.zeros(3))) <= np.deg2rad(54.8)


@pytest.mark.parametrize('radius', [0.004, 0.03])
def test_a_can_on_its_side_does_not_lean(radius):
    """However narrow the facet on which it lies: half a millimetre, for a pen."""
    can = Body.of(model_of_solid('can', solid_of_wall([(radius, 0.0), (radius, 0.15)]), {}))
    axis = np.array([1.0, 0.0, 0.0])
    for angle_deg, lean_deg in ((90.0, 0.0), (70.0, 20.0), (30.0, 30.0)):
        turn = about_axis(axis, np.deg2rad(angle_deg)) @ HALF_A_FACET
        placed = Placed(can, turn, np.zeros(3))
        assert np.rad2deg(lean_angle_rad(placed)) == pytest.approx(lean_deg, abs=0.1)


def test_a_tapered_cup_lies_on_its_side_without_leaning():
    cup = Body.of(model_of_solid('cup', solid_of_wall([(0.03, 0.0), (0.035, 0.12)]), {}))
    lies = np.pi / 2.0 - np.arctan(0.005 / 0.12)
    turn = about_axis(np.array([1.0, 0.0, 0.0]), lies) @ HALF_A_FACET
    placed = Placed(cup, turn, np.zeros(3))
    assert np.rad2deg(lean_angle_rad(placed)) == pytest.approx(0.0, abs=0.2)


def test_centred_on_a_step_that_it_hangs_over_is_neither_on_top_nor_at_the_edge():
    """What is on the upper of two steps and reaches over the lower one seems to be at the edge."""
    steps = box((0.2, 0.2, 0.05)) + box((0.06, 0.2, 0.10)).translate((0.07, 0.0, 0.0))
    stairs = Placed(
        Body.of(model_of_solid('stairs', steps, {})), np.eye(3), np.array([0.0, 0.0, 0.05])
    )
    on_upper_step = np.array([0.07, 0.0, 0.125])
    wide, narrow = body_of((0.14, 0.1, 0.05)), body_of((0.03, 0.1, 0.05))
    over = Footing.of(stairs, Placed(wide, np.eye(3), on_upper_step))
    within = Footing.of(stairs, Placed(narrow, np.eye(3), on_upper_step))
    assert over.on_top_reason() == 'over a step'
    assert over.edge_reason() == 'over both edges'
    assert within.on_top_reason() == ''


def test_measure_names_what_is_wrong():
    assert measure(Relation.ON_TOP, *stacked(TABLE_TOP, FOOT, 0.06)) == 'near the edge'
    assert measure(Relation.ON_TOP_EDGE, *stacked(TABLE_TOP, FOOT, 0.12)) == 'not stable'
    base, relative = stacked(TABLE_TOP, FOOT, 0.0)
    assert measure(Relation.ON_TOP, base, relative.moved(np.array([0, 0, 0.01]))) == 'no contact'
    assert measure(Relation.INCLINED, base, relative) == 'hardly leans'
    assert not isinstance(measure(Relation.ON_TOP, base, relative), str)
