import dataclasses
import math

import numpy as np
import pytest

from spatial_relations_ros.core import Pose, Scene
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.imitation.arrangement import (
    arrangement_difference,
    demonstrated_arrangement,
    is_alike,
)
from spatial_relations_ros.placement.arrangement import Arrangement

WITHIN = Arrangement(0.0, 0.4, 0.0, 0.0, 0.0, 0.0)
AT_EDGE = dataclasses.replace(WITHIN, overhang=0.3, off_centre=0.5)
BESIDE = dataclasses.replace(WITHIN, foot=0.0, seat=-0.5)
IN = dataclasses.replace(WITHIN, foot=0.05, seat=-0.6, sunk=0.9)
UPRIGHT, ON_RIM = (dataclasses.replace(BESIDE, lean_rad=math.radians(angle)) for angle in (20, 70))


@pytest.mark.parametrize('wanted', [WITHIN, AT_EDGE, BESIDE, IN, UPRIGHT])
def test_other_ways_to_show_a_relation_are_unlike(wanted):
    assert is_alike(wanted, wanted)
    assert arrangement_difference(wanted, wanted) == 0.0
    for other in (WITHIN, AT_EDGE, BESIDE, IN, UPRIGHT):
        if other is not wanted:
            assert not is_alike(other, wanted)
            assert arrangement_difference(other, wanted) > 0.45


def test_a_plate_on_its_rim_leans_as_a_book_does():
    assert arrangement_difference(ON_RIM, UPRIGHT) == pytest.approx(0.0)


def test_how_far_over_the_edge_counts_little_by_little():
    overhangs = (0.3, 0.4, 0.5, 0.6)
    differences = [
        arrangement_difference(dataclasses.replace(AT_EDGE, overhang=overhang), AT_EDGE)
        for overhang in overhangs
    ]
    assert differences == sorted(differences)
    assert differences[-1] > differences[1] > 0.0


def test_the_demonstrations_table_is_its_lowest_point(solids):
    low, high = (
        Scene(
            solids.box('slab', (0.2, 0.2, 0.05), (0, 0, 0.025 + table)),
            solids.box('carton', (0.08, 0.08, 0.1), (0.08, 0, 0.1 + table)),
        )
        for table in (0.0, 0.7)
    )
    first, second = demonstrated_arrangement(low), demonstrated_arrangement(high)
    assert first.overhang == pytest.approx(0.25, abs=1e-3)
    for name, value in dataclasses.asdict(first).items():
        assert getattr(second, name) == pytest.approx(value, abs=1e-4)


def test_the_lean_of_a_demonstration_is_known_and_none_of_a_cloud(solids):
    carton = solids.box('carton', (0.05, 0.07, 0.16), (0.3, 0, 0.1))
    base = solids.box('base', (0.1, 0.1, 0.1), (0, 0, 0.05))
    turn = matrix_from_rotvec(np.array([0.4, 0.0, 0.0]))
    leaning = carton.moved_to(Pose.from_rotation(turn, carton.world_from_object.translation))
    assert demonstrated_arrangement(Scene(base, leaning)).lean_rad == pytest.approx(0.4, abs=1e-5)
    cloud = dataclasses.replace(carton, mesh=None)
    assert demonstrated_arrangement(Scene(base, cloud)) is None
