"""Reach of arms as a band around their shoulders."""

import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.imitation import ArmReach

SHOULDERS = np.array([[0.0, 0.2, 0.8], [0.0, -0.2, 0.8]])


def at(x, y=0.2, z=0.8):
    return np.array([x, y, z])


def test_the_band_of_any_arm_is_reached():
    arm = ArmReach(SHOULDERS, 0.25, 0.85)
    reached = arm.reaching(np.array([at(0.5), at(0.1), at(0.9), at(0.9, -0.2)]))
    assert reached.tolist() == [[True, True], [False, True], [False, False], [False, False]]


def test_what_is_out_of_reach_is_told_with_the_distance_from_the_nearest_shoulder():
    arm = ArmReach(SHOULDERS)
    assert arm.problems('mug', {'is now': at(0.5), 'would be': at(0.6)}) == ()
    assert arm.problems('mug', {'is now': at(0.5), 'would be': at(0.95)}) == (
        'mug would be 0.95 m from the nearest shoulder (reach 0.25 to 0.85 m)',
    )
    too_near = arm.problems('mug', {'would be': at(0.0, 0.1)})
    assert too_near == ()  # the other shoulder is 0.30 m away
    near = ArmReach(SHOULDERS[:1]).problems('mug', {'would be': at(0.0, 0.1)})
    assert near == ('mug would be 0.10 m from the nearest shoulder (reach 0.25 to 0.85 m)',)


def test_one_arm_must_reach_all_places():
    arm = ArmReach(SHOULDERS)
    apart = {'is now': at(0.0, 1.0), 'would be': at(0.0, -1.0)}
    (problem,) = arm.problems('mug', apart)
    assert problem.startswith('mug is in reach of no single arm')


@pytest.mark.parametrize(
    'arguments',
    [
        (np.zeros((0, 3)),),
        (np.zeros(3),),
        (np.zeros((2, 2)),),
        (np.full((1, 3), np.nan),),
        (SHOULDERS, 0.9, 0.8),
        (SHOULDERS, -0.1, 0.8),
        (SHOULDERS, 0.1, np.inf),
    ],
)
def test_impossible_arms_are_refused(arguments):
    with pytest.raises(ConfigError):
        ArmReach(*arguments)
