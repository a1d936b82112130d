"""Static equilibrium against textbook cases."""

from __future__ import annotations

import numpy as np
import pytest

from spatial_relations_ros.datasets.objects.model_of_solid import model_of_solid
from spatial_relations_ros.datasets.objects.solids import box
from spatial_relations_ros.placement.body import Body, Placed
from spatial_relations_ros.placement.contact import travel_to_contact
from spatial_relations_ros.placement.resting import about_axis
from spatial_relations_ros.placement.stability import (
    equilibrium_residual,
    is_stable,
    resting_contacts,
)


def body_of(size, *, density: float = 1000.0) -> Body:
    return Body.of(model_of_solid('test', box(size), {}, density=density))


@pytest.fixture(scope='module')
def slab() -> Body:
    return body_of((0.2, 0.2, 0.05))


def stacked(base: Body, relative: Body, offset: float) -> tuple[Placed, Placed]:
    fixed = Placed(base, np.eye(3), np.zeros(3)).on_table()
    top = fixed.world_vertices[:, 2].max() + relative.model.half_extents[2]
    return fixed, Placed(relative, np.eye(3), np.array([offset, 0.0, top]))


def stable(pair: tuple[Placed, Placed]) -> bool:
    return is_stable(*pair, resting_contacts(*pair))


@pytest.mark.parametrize(('offset', 'expected'), [(0.0, True), (0.09, True), (0.11, False)])
def test_a_cube_stands_until_its_centre_is_beyond_the_edge(slab, offset, expected):
    assert stable(stacked(slab, body_of((0.06, 0.06, 0.06)), offset)) is expected


def test_a_heavy_load_at_the_rim_tips_a_light_table(slab):
    # The foot reaches 4 cm from the middle, the load stands 10 cm from it.
    foot = box((0.08, 0.2, 0.05)) + box((0.24, 0.2, 0.01), bottom=0.05)
    base = Body.of(model_of_solid('table', foot, {}, density=100.0))
    load = body_of((0.05, 0.05, 0.05))
    assert stable(stacked(base, load, 0.0))
    assert not stable(stacked(base, load, 0.1))
    heavy = Body.of(model_of_solid('table', foot, {}, density=5000.0))
    assert stable(stacked(heavy, load, 0.1))


def leaning(angle_deg: float) -> tuple[Placed, Placed]:
    wall = Placed(body_of((0.1, 0.3, 0.3), density=3000.0), np.eye(3), np.zeros(3)).on_table()
    board = Placed(
        body_of((0.01, 0.1, 0.28)),
        about_axis(np.array([0.0, 1.0, 0.0]), np.deg2rad(angle_deg)),
        np.array([-0.6, 0.0, 0.0]),
    ).on_table()
    direction = np.array([1.0, 0.0, 0.0])
    return wall, board.moved(direction * travel_to_contact(board, wall, direction))


def test_a_board_slips_when_it_leans_too_flat():
    # Ladder with friction mu at both ends: tan(angle from the wall) < 2 mu / (1 - mu^2).
    limit = np.rad2deg(np.arctan(2 * 0.5 / (1 - 0.25)))
    assert stable(leaning(limit - 6.0))
    assert not stable(leaning(limit + 6.0))


def test_a_floating_body_falls(slab):
    fixed, relative = stacked(slab, body_of((0.06, 0.06, 0.06)), 0.0)
    lifted = relative.moved(np.array([0.0, 0.0, 0.01]))
    contacts = resting_contacts(fixed, lifted)
    assert equilibrium_residual(fixed, lifted, contacts) > 0.5
