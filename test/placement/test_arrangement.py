import numpy as np
import pytest

from spatial_relations_ros.datasets.objects.model_of_solid import model_of_solid
from spatial_relations_ros.datasets.objects.solids import box
from spatial_relations_ros.placement.arrangement import Arrangement
from spatial_relations_ros.placement.body import Body, Placed
from spatial_relations_ros.placement.model import ObjectModel
from spatial_relations_ros.placement.openings import find_opening
from spatial_relations_ros.placement.resting import about_axis


def body_of(size) -> Body:
    return Body.of(model_of_solid('test', box(size), {}))


def arranged(base: Body, relative: Body, x: float, z: float, *, lean_rad: float = 0.0):
    fixed = Placed(base, np.eye(3), np.zeros(3)).on_table()
    turn = about_axis(np.array([1.0, 0.0, 0.0]), lean_rad)
    return Arrangement.of(fixed, Placed(relative, turn, np.array([x, 0.0, z])))


@pytest.fixture(scope='module')
def slab():
    return body_of((0.2, 0.2, 0.05))


@pytest.fixture(scope='module')
def cube():
    return body_of((0.08, 0.08, 0.08))


@pytest.mark.parametrize(('x', 'overhang'), [(0.0, 0.0), (0.06, 0.0), (0.08, 0.25), (0.1, 0.5)])
def test_overhang_is_the_share_of_the_foot_beyond_the_support(slab, cube, x, overhang):
    found = arranged(slab, cube, x, 0.09)
    assert found.overhang == pytest.approx(overhang, abs=1e-3)
    assert found.seat == pytest.approx(0.0, abs=1e-6)
    assert found.foot == pytest.approx(0.05 / 0.13, abs=1e-6)


def test_a_board_on_a_can_hangs_over_everywhere_and_is_centred(cube):
    found = arranged(cube, body_of((0.2, 0.2, 0.02)), 0.0, 0.09)
    assert found.overhang > 0.2
    assert found.off_centre == pytest.approx(0.0, abs=1e-3)


def test_what_stands_on_the_table_hangs_over_nothing(slab, cube):
    found = arranged(slab, cube, 0.3, 0.04)
    assert (found.overhang, found.sunk) == (0.0, 0.0)
    assert found.foot == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize('lean_rad', [0.0, 0.2, 0.6])
def test_lean_is_the_angle_to_the_nearest_face(slab, cube, lean_rad):
    found = arranged(slab, cube, 0.3, 0.1, lean_rad=lean_rad)
    assert found.lean_rad == pytest.approx(lean_rad, abs=1e-5)


def test_depth_is_the_share_below_the_rim(solids):
    cup = solids.cup('pot', 0.06, 0.1, (0, 0, 0)).mesh
    opening = find_opening(cup).opening
    pot = Body.of(ObjectModel('pot', '', cup, {}, opening, 1000.0))
    stick = body_of((0.03, 0.03, 0.1))
    base = Placed(pot, np.eye(3), np.zeros(3))
    half_in = Placed(stick, np.eye(3), np.array([0.0, 0.0, opening.rim_z]))
    assert Arrangement.of(base, half_in).sunk == pytest.approx(0.05 / opening.depth, abs=0.02)
    above = half_in.moved(np.array([0.0, 0.0, 0.06]))
    assert Arrangement.of(base, above).sunk == 0.0


def test_what_stands_in_a_tray_stands_on_top_of_it_and_what_lies_in_it_is_inside(solids):
    cup = solids.cup('tray', 0.12, 0.03, (0, 0, 0)).mesh
    opening = find_opening(cup).opening
    base = Placed(
        Body.of(ObjectModel('tray', '', cup, {}, opening, 1000.0)), np.eye(3), np.zeros(3)
    )
    for height, is_inside in ((0.1, False), (0.02, True)):
        item = body_of((0.05, 0.05, height))
        z = opening.floor_z + height / 2.0
        found = Arrangement.of(base, Placed(item, np.eye(3), np.array([0.0, 0.0, z])))
        assert (found.sunk > 0.9) is is_inside
