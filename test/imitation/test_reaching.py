"""The search looks where arms reach, among headings that show the relation alike."""

import dataclasses

import numpy as np
import pytest

from spatial_relations_ros.core import Scene
from spatial_relations_ros.imitation import ArmReach, ImitationOptions, imitate

QUICK = ImitationOptions(num_proposals=16, max_steps=4)


@pytest.fixture(scope='module')
def beside(solids):
    return Scene(
        solids.box('left', (0.1, 0.1, 0.1), (0.0, 0.0, 0.05)),
        solids.box('right', (0.1, 0.1, 0.1), (0.0, -0.16, 0.05)),
    )


def table(solids, side):
    """The carton stands far from the tray, on the arm's side."""
    return Scene(
        solids.box('tray', (0.2, 0.2, 0.04), (0.0, 0.0, 0.02)),
        solids.box('carton', (0.07, 0.07, 0.12), (0.5 * side[0], 0.5 * side[1], 0.06)),
    )


@pytest.mark.parametrize('side', [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
def test_the_answer_is_on_the_side_that_the_arm_reaches(metric, beside, solids, side):
    # A sixth of all headings about the tray is in reach.
    shoulder = np.array([[0.6 * side[0], 0.6 * side[1], 0.3]])
    options = dataclasses.replace(QUICK, arm=ArmReach(shoulder, 0.2, 0.49))
    result = imitate(metric, beside, table(solids, side), options)
    assert result.success, result.message
    relative = result.answers[0].placements[1]
    assert relative.reachable
    assert relative.target.translation[:2] @ side > 0.05
    # As near to the tray as shown, not where it stood.
    assert np.linalg.norm(relative.target.translation[:2]) < 0.35


def test_what_no_arm_reaches_is_refused_with_the_distance(metric, beside, solids):
    arm = ArmReach(np.array([[5.0, 0.0, 0.3]]), 0.2, 0.6)
    stacked = Scene(
        solids.box('tray', (0.2, 0.2, 0.04), (0.0, 0.0, 0.02)),
        solids.box('carton', (0.07, 0.07, 0.12), (0.0, 0.0, 0.1)),
    )
    result = imitate(metric, beside, stacked, dataclasses.replace(QUICK, arm=arm))
    assert not result.success
    assert 'from the nearest shoulder (reach 0.2 to 0.6 m)' in result.message
