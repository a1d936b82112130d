"""Where a body finds a foothold, on solids whose answer is known."""

import numpy as np
import pytest
from manifold3d import Manifold

from spatial_relations_ros.datasets.objects.model_of_solid import model_of_solid
from spatial_relations_ros.datasets.objects.solids import box
from spatial_relations_ros.placement.body import Body, Placed
from spatial_relations_ros.placement.footholds import Footholds, find_footholds
from spatial_relations_ros.placement.resting import UP, dropped
from spatial_relations_ros.placement.tipping import tipped


def body_of(solid: Manifold) -> Body:
    return Body.of(model_of_solid('test', solid, {}))


@pytest.fixture(scope='module')
def cube() -> Placed:
    return Placed(body_of(box((0.06, 0.06, 0.06))), np.eye(3), np.array([0.5, 0.2, 0.03]))


def footholds(moving: Placed, fixed: Placed) -> Footholds:
    return find_footholds(moving, fixed, np.random.default_rng(0))


def on_table(solid: Manifold) -> Placed:
    return Placed(body_of(solid), np.eye(3), np.zeros(3)).on_table()


def test_two_posts_carry_a_cube_between_them_and_one_thin_post_does_not(cube):
    post = box((0.03, 0.06, 0.05))
    pair = on_table(post.translate([-0.03, 0.0, 0.0]) + post.translate([0.03, 0.0, 0.0]))
    found = footholds(cube, pair)
    steadiest = cube.moved(np.append(found.offsets[found.hold.argmax()], 0.0))
    np.testing.assert_allclose(steadiest.translation[:2], 0.0, atol=0.01)
    needle = on_table(Manifold.cylinder(0.05, 0.002, 0.0005, 16, True))
    assert footholds(cube, needle).hold.max(initial=0.0) < 0.1 * found.hold.max()


def test_what_it_finds_comes_to_rest_nearly_level(cube):
    stairs = on_table(
        box((0.1, 0.1, 0.04)).translate([0.0, 0.0, 0.02])
        + box((0.1, 0.1, 0.043)).translate([0.1, 0.0, 0.0215])
    )
    found = footholds(cube, stairs)
    assert len(found.offsets) > 20
    for offset in found.offsets[np.argsort(-found.hold)[:5]]:
        placed = tipped(dropped(cube.moved(np.append(offset, 0.2)), stairs), stairs)
        assert placed is not None
        assert placed.rotation[2, 2] > np.cos(np.deg2rad(9.5))
        assert placed.world_vertices[:, 2].min() > 0.03


def test_a_ball_is_no_place_to_stand(cube):
    ball = on_table(Manifold.sphere(0.05, 64))
    slab = on_table(box((0.1, 0.1, 0.1)))
    assert footholds(cube, slab).hold.max() > 3.0 * footholds(cube, ball).hold.max()


def test_the_place_of_the_moving_body_does_not_matter(cube):
    slab = on_table(box((0.1, 0.1, 0.1)))
    here, there = footholds(cube, slab), footholds(cube.moved(0.3 * UP), slab)
    np.testing.assert_allclose(here.offsets, there.offsets, atol=1e-9)
