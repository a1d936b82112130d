"""Placements proposed from the shapes are at rest, of all kinds, and the same for a seed."""

import numpy as np
import pytest

from spatial_relations_ros.core import Pose, Scene
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.imitation.orientations import resting_orientations
from spatial_relations_ros.imitation.proposals import Proposer
from spatial_relations_ros.imitation.shape import shape_of
from spatial_relations_ros.imitation.tabletop import Tabletop
from spatial_relations_ros.placement.contact import clearance
from spatial_relations_ros.placement.settling import Manner


@pytest.fixture(scope='module')
def pair(solids):
    return Scene(
        solids.cup('pot', 0.09, 0.12, (0.5, 0.2, 0.76)),
        solids.box('carton', (0.05, 0.07, 0.16), (0.9, 0.1, 0.78)),
    )


@pytest.fixture(scope='module')
def tabletop(pair):
    shapes = tuple(shape_of(item) for item in pair.objects)
    return Tabletop.of(shapes, pair.base.world_from_object, 0.7)


def proposer(pair, tabletop, seed=0, **settings):
    base, relative = (
        tabletop.placed(role, item.world_from_object) for role, item in enumerate(pair.objects)
    )
    orientations = resting_orientations(relative.body, relative.rotation)
    rng = np.random.default_rng(seed)
    return Proposer([base], relative.body, orientations, rng, **settings)


def test_a_placed_body_has_its_objects_pose(pair, tabletop):
    for role, item in enumerate(pair.objects):
        placed = tabletop.placed(role, item.world_from_object)
        assert tabletop.pose(role, placed).is_close(
            item.world_from_object, metres=1e-9, angle_rad=1e-7
        )
        low = placed.world_vertices.min(axis=0)[2]
        assert low == pytest.approx(item.world_points[:, 2].min() - 0.7, abs=1e-4)


def test_all_manners_are_proposed_and_nothing_overlaps(pair, tabletop):
    made = proposer(pair, tabletop)
    manners = set()
    for idx in range(len(made.cells)):
        proposal = made.draw(idx)
        if proposal is None:
            continue
        manners.add(proposal.manner)
        # A quarter of the contact points is looked at: edges may cross by a little.
        assert clearance(proposal.base, proposal.relative) > -0.004
        assert proposal.relative.world_vertices[:, 2].min() > -1e-6
    assert manners == {Manner.BESIDE, Manner.DROPPED, Manner.LEANING, Manner.IN_RIM}


def test_what_is_to_stay_upright_is_not_leant(pair, tabletop):
    made = proposer(pair, tabletop, may_lean=False)
    assert {cell.manner for cell in made.cells} == {Manner.BESIDE, Manner.DROPPED}


def test_the_same_seed_proposes_the_same(pair, tabletop):
    first, second = (proposer(pair, tabletop, seed=5) for _ in range(2))
    for idx in range(6):
        a, b = first.draw(idx), second.draw(idx)
        assert (a is None) == (b is None)
        if a is not None:
            np.testing.assert_array_equal(a.relative.translation, b.relative.translation)


def test_a_variation_is_near_and_at_rest(pair, tabletop):
    made = proposer(pair, tabletop)
    proposal = next(p for p in map(made.draw, range(len(made.cells))) if p is not None)
    varied = [v for v in (made.vary(proposal) for _ in range(8)) if v is not None]
    assert varied
    for variation in varied:
        shift = variation.relative.translation - proposal.relative.translation
        assert 0.0 < np.linalg.norm(shift) < 0.25
        assert variation.manner is proposal.manner


def test_a_heading_is_kept(pair, tabletop):
    heading = np.array([0.0, -1.0])
    made = proposer(pair, tabletop, heading=heading)
    beside = [i for i, cell in enumerate(made.cells) if cell.manner is Manner.BESIDE]
    for idx in beside:
        proposal = made.draw(idx)
        offset = (proposal.relative.translation - proposal.base.translation)[:2]
        assert offset @ heading > 0.9 * np.linalg.norm(offset)


def test_orientations_begin_with_the_present_one_made_level(pair, tabletop):
    tilt = matrix_from_rotvec(np.array([0.05, 0.0, 0.0]))
    pose = pair.relative.world_from_object
    tilted = Pose.from_rotation(tilt @ pose.rotation, pose.translation)
    placed = tabletop.placed(1, tilted)
    orientations = resting_orientations(placed.body, placed.rotation)
    assert orientations[0][2, 2] == pytest.approx(1.0, abs=1e-9)
    # A carton with three different sides: upright and on two sides, whichever is up.
    heights = {round(float(np.abs(r[2]) @ [0.05, 0.07, 0.16]), 3) for r in orientations}
    assert heights == {0.05, 0.07, 0.16}
