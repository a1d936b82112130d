import dataclasses
import gc
import weakref

import numpy as np
import pytest
from manifold3d import Manifold

from spatial_relations_ros.core import Pose
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.imitation.contact import Body
from spatial_relations_ros.imitation.feasibility import check_placement, distance_to_hull
from spatial_relations_ros.imitation.shape import shape_of
from spatial_relations_ros.imitation.solids import solid_of
from spatial_relations_ros.placement.contact import travel_to_contact


@pytest.fixture
def check(solids):
    base = solids.box('plate', (0.2, 0.2, 0.05), (0, 0, 0.025))

    def at(position, rotvec=(0, 0, 0), size=(0.06, 0.06, 0.1)):
        pose = Pose.from_rotation(matrix_from_rotvec(np.array(rotvec, float)), position)
        item = solids.box('carton', size, (0, 0, 0)).moved_to(pose)
        bodies = [Body(shape_of(o), o.world_from_object) for o in (item, base)]
        return check_placement('carton', bodies[0], 'plate', bodies[1], 0.0)

    return at


def test_a_shape_keeps_the_solids_of_few_scales(solids):
    shape = shape_of(solids.box('crate', (0.9, 0.6, 0.6), (0, 0, 0.3)))
    made = [weakref.ref(solid_of(shape, scale)) for scale in np.linspace(0.1, 0.3, 20)]
    gc.collect()
    assert sum(solid() is not None for solid in made) <= 4
    latest = made[-1]()
    assert latest is solid_of(shape, 0.3)


def test_a_box_on_a_plate_is_feasible(check):
    result = check((0, 0, 0.1))
    assert result.violations == ()
    assert result.supported
    assert result.penetration < 1e-3


def test_overlap_is_told_in_millimetres(check):
    result = check((0, 0, 0.085))
    assert 'carton would overlap plate by 15 mm' in result.violations[0]
    assert result.penetration == pytest.approx(0.015, abs=1e-3)


def test_hanging_in_the_air_is_told(check):
    result = check((0, 0, 0.2))
    assert result.violations == ('carton would hang 150 mm above the table and touch nothing',)
    assert not result.supported


def test_below_the_table_is_told(check):
    result = check((0.3, 0, 0.03))
    assert any('20 mm below the table' in text for text in result.violations)


def test_too_far_over_the_edge_tips(check):
    assert check((0.09, 0, 0.1)).supported
    assert any('would not stay' in text for text in check((0.12, 0, 0.1)).violations)


def test_balancing_on_an_edge_does_not_stay(check):
    half_diagonal = 0.03 * np.sqrt(2)
    cube = (0.06, 0.06, 0.06)
    on_edge = check((0.3, 0, half_diagonal), rotvec=(0, np.pi / 4, 0), size=cube)
    assert not on_edge.supported
    assert check((0.3, 0, 0.03), size=cube).supported


def test_leaning_needs_something_to_lean_on(solids):
    tilt = np.array([0.0, -np.deg2rad(20.0), 0.0])
    board = solids.box('board', (0.02, 0.1, 0.2), (0, 0, 0))
    height = 0.5 * (np.abs(matrix_from_rotvec(tilt)[2]) @ [0.02, 0.1, 0.2])
    leaning = board.moved_to(Pose.from_rotation(matrix_from_rotvec(tilt), [0, 0, height]))
    wall = solids.box('wall', (0.1, 0.2, 0.3), (-0.5, 0, 0.15))
    body, far = (Body(shape_of(o), o.world_from_object) for o in (leaning, wall))
    alone = check_placement('board', body, 'wall', far, 0.0)
    assert not alone.supported
    placed, fixed = (solid_of(b.shape, 1.0).placed(b.pose, (0, 0, 0)) for b in (body, far))
    travel = travel_to_contact(placed, fixed, np.array([-1.0, 0, 0]))
    against = body.shifted(np.array([-(travel - 0.0002), 0.0, 0.0]))
    assert check_placement('board', against, 'wall', far, 0.0).violations == ()


def test_a_load_must_not_tip_what_it_stands_on(solids):
    foot = solids.of(
        'table',
        Manifold.cube((0.3, 0.1, 0.01), True).translate((0, 0, 0.1))
        + Manifold.cube((0.06, 0.06, 0.1), True).translate((0, 0, 0.05)),
        (0, 0, 0),
    )
    for x, stays in ((0.0, True), (0.12, False)):
        load = solids.box('load', (0.05, 0.05, 0.2), (x, 0, 0.2052))
        body, base = (Body(shape_of(o), o.world_from_object) for o in (load, foot))
        assert check_placement('load', body, 'table', base, 0.0).supported is stays


def test_a_cloud_is_judged_by_its_centre_of_mass(solids):
    plate = solids.box('plate', (0.2, 0.2, 0.05), (0, 0, 0.025))
    for x, supported in ((0.05, True), (0.14, False)):
        item = dataclasses.replace(solids.box('carton', (0.06, 0.06, 0.1), (x, 0, 0.1)), mesh=None)
        body, base = (Body(shape_of(o), o.world_from_object) for o in (item, plate))
        result = check_placement('carton', body, 'plate', base, 0.0)
        assert result.supported is supported
        assert all('estimated from a cloud' in text for text in result.violations)


def test_distance_to_a_hull():
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5]])
    assert distance_to_hull(square, np.array([0.2, 0.7])) == 0.0
    assert distance_to_hull(square, np.array([1.5, 0.5])) == pytest.approx(0.5)
    line = np.array([[0.0, 0], [1, 0], [0.5, 0]])
    assert distance_to_hull(line, np.array([0.5, 0.25])) == pytest.approx(0.25)
    assert distance_to_hull(np.array([[1.0, 1.0]]), np.array([1.0, 3.0])) == pytest.approx(2.0)
