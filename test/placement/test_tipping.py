"""What tilts until it rests, and what then rolls, on solids whose answer is known."""

import numpy as np
import pytest
from manifold3d import Manifold

from spatial_relations_ros.datasets.objects.model_of_solid import model_of_solid
from spatial_relations_ros.datasets.objects.solids import box
from spatial_relations_ros.placement.body import Body, Placed
from spatial_relations_ros.placement.contact import clearance
from spatial_relations_ros.placement.resting import about_axis
from spatial_relations_ros.placement.tipping import MAX_ROLL_RAD, Ground, tipped

X = np.array([1.0, 0.0, 0.0])
LYING = about_axis(X, np.pi / 2)


def body_of(solid: Manifold) -> Body:
    return Body.of(model_of_solid('test', solid, {}))


@pytest.fixture(scope='module')
def slab() -> Placed:
    return Placed(body_of(box((0.2, 0.2, 0.05))), np.eye(3), np.array([0.0, 0.0, 0.025]))


@pytest.fixture(scope='module')
def cube() -> Body:
    return body_of(box((0.06, 0.06, 0.06)))


@pytest.fixture(scope='module')
def can() -> Body:
    return body_of(Manifold.cylinder(0.1, 0.03, 0.03, 64, True))


def over(body: Body, x: float = 0.0, rotation=None) -> Placed:
    rotation = np.eye(3) if rotation is None else rotation
    return Placed(body, rotation, np.array([x, 0.0, 0.15]))


def roll_deg(placed: Placed, fixed: Placed, tilt_deg: float) -> float:
    ground = Ground.below(placed.moved(np.array([0.0, 0.0, 3e-4])), fixed)
    return float(np.rad2deg(ground.roll_rad(np.deg2rad(tilt_deg))))


def test_what_is_let_down_askew_comes_to_lie_flat(slab, cube):
    rested = tipped(over(cube, rotation=about_axis(X, 0.1)), slab)
    assert rested.rotation[2, 2] == pytest.approx(1.0, abs=1e-5)
    assert rested.world_vertices[:, 2].min() == pytest.approx(0.05, abs=1e-5)


@pytest.mark.parametrize(('x', 'rests'), [(0.0, True), (0.095, True), (0.105, False)])
def test_it_falls_off_when_its_centre_is_over_the_edge(slab, cube, x, rests):
    assert (tipped(over(cube, x), slab) is not None) == rests


def test_on_two_steps_it_leans_from_one_to_the_other(cube):
    """A long bar over a step 2 cm high and the table tilts by asin(2 cm / length)."""
    step = Placed(body_of(box((0.04, 0.1, 0.01))), np.eye(3), np.array([0.0, 0.0, 0.005]))
    bar = body_of(box((0.2, 0.02, 0.02)))
    rested = tipped(over(bar, 0.06), step)
    # One end on the table, 14 cm from where the step's far edge would carry it.
    tilt = np.arcsin(rested.rotation[0, 2])
    assert abs(tilt) > np.deg2rad(2.0)
    assert abs(clearance(step, rested)) < 3e-4
    assert rested.world_vertices[:, 2].min() == pytest.approx(0.0, abs=3e-4)


def test_a_lying_can_rolls_and_a_standing_one_does_not(slab, can):
    lying, standing = tipped(over(can, rotation=LYING), slab), tipped(over(can), slab)
    limit = np.rad2deg(MAX_ROLL_RAD)
    assert roll_deg(lying, slab, 4.0) > limit
    assert roll_deg(standing, slab, 4.0) < limit
    assert roll_deg(standing, slab, 35.0) > limit  # atan(3 / 5) is 31 degrees


def test_a_ball_rolls(slab):
    ball = tipped(over(body_of(Manifold.sphere(0.03, 64))), slab)
    assert roll_deg(ball, slab, 4.0) > np.rad2deg(MAX_ROLL_RAD)


def test_a_ball_in_a_dent_that_is_wider_stays():
    dented = box((0.2, 0.2, 0.08)) - Manifold.sphere(0.06, 64).translate((0.0, 0.0, 0.08))
    dent = Placed(body_of(dented), np.eye(3), np.array([0.0, 0.0, 0.04]))
    ball = tipped(over(body_of(Manifold.sphere(0.03, 64))), dent)
    assert ball.world_vertices[:, 2].min() == pytest.approx(0.02, abs=1e-3)
    # It turns as far as the table and comes back; on level ground it would roll on.
    assert roll_deg(ball, dent, 2.0) < 6.0
