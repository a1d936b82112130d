"""The order in which objects go to their targets."""

import numpy as np
import pytest

from spatial_relations_ros.imitation.contact import Body
from spatial_relations_ros.imitation.manipulation.moves import MovePlanner
from spatial_relations_ros.imitation.shape import shape_of

BASE, RELATIVE = 0, 1


def body_of(item):
    return Body(shape_of(item), item.world_from_object)


@pytest.fixture
def tray(solids):
    return body_of(solids.box('tray', (0.2, 0.2, 0.02), (0, 0, 0.01)))


@pytest.fixture
def carton(solids):
    return body_of(solids.box('carton', (0.06, 0.06, 0.1), (0, 0, 0.05)))


def moved(body, *offset):
    return body.shifted(np.array(offset, dtype=float))


def plan(now, goal, moves=(True, True)):
    return MovePlanner(now, (), 0.0, 0.1).plan(goal, moves)


def test_the_base_goes_first(tray, carton):
    now = moved(tray, 0.5, 0, 0), moved(carton, -0.5, 0, 0)
    found = plan(now, (tray, moved(carton, 0, 0, 0.0202)))
    assert found.steps == ((BASE, True), (RELATIVE, True))
    assert all(approach.is_clear for approach in found.approaches)


def test_what_carries_the_base_goes_before_it(tray, carton):
    now = moved(carton, 0.5, 0, 0), moved(tray, -0.5, 0, 0)
    goal = moved(carton, 0, 0, 0.0202), tray  # the relative is below
    assert plan(now, goal).steps == ((RELATIVE, True), (BASE, True))


def test_a_relative_in_the_way_of_the_base_goes_first_when_it_can_stand(tray, carton):
    now = moved(tray, 0.5, 0, 0), carton  # the carton stands where the tray should go
    found = plan(now, (tray, moved(carton, 0.2, 0, 0)))
    assert found.steps == ((RELATIVE, True), (BASE, True))


def test_a_relative_in_the_way_that_needs_the_base_is_put_aside(tray, carton):
    now = moved(tray, 0.5, 0, 0), carton
    found = plan(now, (tray, moved(carton, 0, 0, 0.0202)))
    assert found.steps == ((RELATIVE, False), (BASE, True), (RELATIVE, True))


def test_what_stands_on_the_base_now_is_put_aside(tray, carton):
    now = tray, moved(carton, 0, 0, 0.0202)
    goal = moved(tray, 0.5, 0, 0), moved(carton, 0.55, 0, 0.0202)
    assert plan(now, goal).steps == ((RELATIVE, False), (BASE, True), (RELATIVE, True))


def test_a_single_move_is_one_step(tray, carton):
    now = tray, moved(carton, 0.5, 0, 0)
    found = plan(now, (tray, moved(carton, 0, 0, 0.0202)), (False, True))
    assert found.steps == ((RELATIVE, True),)
    assert found.approaches[BASE] is None
    assert plan(now, now, (False, False)).steps == ()


def test_a_load_on_what_moves_alone_is_taken_off_and_put_back(tray, carton):
    now = moved(carton, 0, 0, 0.0202), tray  # the base stands on the relative
    goal = now[0], moved(tray, 0.3, 0, 0)
    assert plan(now, goal, (False, True)).steps == (
        (BASE, False),
        (RELATIVE, True),
        (BASE, True),
    )


def test_the_base_may_pass_where_the_relative_will_be(solids, carton):
    """The way of what goes first must not avoid what is not there yet."""
    box = body_of(solids.cup('pot', 0.08, 0.12, (0, 0, 0.06)))
    now = moved(box, 0.5, 0, 0), moved(carton, -0.5, 0, 0)
    found = plan(now, (box, moved(carton, 0, 0, 0.0042)))
    assert found.steps == ((BASE, True), (RELATIVE, True))
    np.testing.assert_allclose(found.approaches[BASE].pose.translation, [0, 0, 0.16], atol=1e-9)
