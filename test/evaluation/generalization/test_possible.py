"""Whether there is any placement, on pairs of which that is plain."""

import pytest

from spatial_relations_ros.core import Relation, Scene
from spatial_relations_ros.evaluation.generalization.cases import Case
from spatial_relations_ros.evaluation.generalization.possible import look_for_any

pytest.importorskip('mujoco')


def case_of(solids, relative_size):
    """A carton on a slab shown, and another carton that shall be put on a block."""
    shown = Scene(
        solids.box('slab', (0.2, 0.2, 0.05), (0, 0, 0.025)),
        solids.box('carton', (0.06, 0.06, 0.1), (0, 0, 0.1)),
    )
    test = Scene(
        solids.box('block', (0.2, 0.16, 0.08), (0, 0, 0.04)),
        solids.box('box', relative_size, (0.5, 0, 0.5 * relative_size[2])),
    )
    return Case(0, 'test', Relation.ON_TOP, shown, test, 'shown', 'test', ('relative',))


def test_a_placement_of_what_fits_is_found(solids):
    found = look_for_any(case_of(solids, (0.05, 0.05, 0.07)), num_drawn=60)
    assert found.right
    assert found.imitated >= found.simulated >= 1


def test_none_is_found_where_the_depth_that_is_shown_cannot_be_reached(solids):
    shown = Scene(
        solids.cup('pot', 0.06, 0.1, (0, 0, 0.05)),
        solids.box('stick', (0.02, 0.02, 0.08), (0, 0, 0.0492)),
    )
    test = Scene(
        solids.cup('mug', 0.03, 0.08, (0, 0, 0.04)),
        solids.box('brick', (0.1, 0.12, 0.14), (0.4, 0, 0.07)),
    )
    case = Case(0, 'test', Relation.INSIDE, shown, test, 'shown', 'test', ('relative',))
    found = look_for_any(case, num_drawn=40)
    assert not found.right
    assert found.imitated == 0
