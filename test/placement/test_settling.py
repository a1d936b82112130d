import numpy as np
import pytest

from spatial_relations_ros.datasets.objects import sample_object
from spatial_relations_ros.placement.body import Body, Placed
from spatial_relations_ros.placement.contact import clearance
from spatial_relations_ros.placement.inside import place_inside_lying
from spatial_relations_ros.placement.leaning_on import place_inclined, place_inside_inclined
from spatial_relations_ros.placement.resting import (
    LEANING_WAYS,
    RELATIVE_WAYS,
    SIDE_ONLY,
    UPRIGHT_ONLY,
    about_axis,
    rest_on_table,
)
from spatial_relations_ros.placement.settling import Manner, settle, snapped


def body_of(family, seed=0):
    return Body.of(sample_object(family, np.random.default_rng(seed)))


@pytest.fixture(scope='module')
def carton():
    return body_of('teabox')


@pytest.fixture(scope='module')
def pot():
    return body_of('pot')


def nudged(placed, shift, angle_rad):
    turn = about_axis(np.array([0.6, 0.8, 0.0]), angle_rad)
    return Placed(placed.body, turn @ placed.rotation, placed.translation + shift)


def test_what_is_nearly_level_is_made_level(carton):
    tilted = nudged(Placed(carton, np.eye(3), np.zeros(3)), np.zeros(3), np.deg2rad(7))
    assert snapped(tilted).rotation[2, 2] == pytest.approx(1.0, abs=1e-9)
    leaning = nudged(tilted, np.zeros(3), np.deg2rad(20))
    np.testing.assert_array_equal(snapped(leaning).rotation, leaning.rotation)


def test_what_overlaps_is_moved_beside(carton, pot):
    fixed = Placed(pot, np.eye(3), np.zeros(3)).on_table()
    inside = Placed(carton, np.eye(3), np.array([0.5 * pot.radius, 0.0, 0.1]))
    beside = settle(Manner.BESIDE, inside, fixed)
    assert clearance(beside, fixed) > 0.0
    assert beside.world_vertices[:, 2].min() == pytest.approx(0.0, abs=1e-6)
    far = inside.moved(np.array([1.0, 0.0, 0.0]))
    np.testing.assert_allclose(
        settle(Manner.BESIDE, far, fixed).translation[:2], [1.0 + inside.translation[0], 0.0]
    )


def test_what_is_let_down_lands_on_the_other(carton):
    base = body_of('book')
    fixed = Placed(base, np.eye(3), np.zeros(3)).on_table()
    hovering = nudged(Placed(carton, np.eye(3), np.array([0.01, 0.0, 0.02])), np.zeros(3), 0.05)
    landed = settle(Manner.DROPPED, hovering, fixed)
    assert abs(clearance(landed, fixed)) < 1e-4
    np.testing.assert_allclose(landed.translation[:2], [0.01, 0.0], atol=1e-9)


@pytest.mark.parametrize(
    ('rule', 'manner', 'base_ways', 'ways'),
    [
        (place_inclined, Manner.LEANING, UPRIGHT_ONLY, LEANING_WAYS),
        (place_inside_inclined, Manner.IN_RIM, UPRIGHT_ONLY, LEANING_WAYS),
        (place_inside_lying, Manner.LOWERED, SIDE_ONLY, RELATIVE_WAYS),
    ],
)
def test_a_nudged_placement_settles_near_where_it_was(rule, manner, base_ways, ways):
    rng = np.random.default_rng(4)
    base, relative = body_of('bucket'), body_of('brush', 2)
    num_settled = 0
    for _ in range(30):
        fixed = rest_on_table(base, base_ways, rng)
        placed = rule(fixed, rest_on_table(relative, ways, rng), rng)
        if isinstance(placed, str):
            continue
        settled = settle(manner, nudged(placed, rng.normal(0.0, 0.002, 3), 0.01), fixed)
        if settled is None:
            continue
        num_settled += 1
        on_table = settled.world_vertices[:, 2].min() < 1e-6
        assert clearance(settled, fixed) > -5e-4
        assert on_table or clearance(settled, fixed) < 5e-4
        assert np.linalg.norm(settled.translation - placed.translation) < 0.08
    assert num_settled >= 3
