import numpy as np
import pytest

from spatial_relations_ros.imitation.contact import Body, overlap, reach_through
from spatial_relations_ros.imitation.shape import shape_of


def body(item):
    return Body(shape_of(item), item.world_from_object)


def test_overlap_is_the_depth(solids):
    base = body(solids.box('base', (0.2, 0.2, 0.2), (0, 0, 0.1)))
    sunk = body(solids.box('box', (0.04, 0.04, 0.04), (0, 0, 0.21)))
    assert overlap(sunk, base) == pytest.approx(0.01, abs=1e-3)
    clear = body(solids.box('box', (0.04, 0.04, 0.04), (0, 0, 0.23)))
    assert overlap(clear, base) == 0.0


def test_crossing_thin_walls_are_found_though_they_are_hardly_deep(solids):
    cup = body(solids.cup('cup', 0.05, 0.1, (0, 0, 0.05), wall=0.002))
    across = body(solids.cup('other', 0.05, 0.1, (0.06, 0, 0.08), wall=0.002))
    assert overlap(across, cup) < 0.003
    assert reach_through(across, cup) > 0.01
    beside = body(solids.cup('other', 0.05, 0.1, (0.1005, 0, 0.08), wall=0.002))
    assert reach_through(beside, cup) == 0.0
    nested = body(solids.cup('other', 0.04, 0.1, (0, 0, 0.06), wall=0.002))
    assert reach_through(nested, cup) == 0.0


def test_the_overlap_of_a_few_points_is_that_of_all(solids):
    base = body(solids.cup('base', 0.05, 0.1, (0, 0, 0.05), wall=0.004))
    rng = np.random.default_rng(0)
    for _ in range(20):
        other = solids.box('box', (0.05, 0.04, 0.06), (*rng.uniform(-0.08, 0.08, 2), 0.06))
        moved = body(other)
        every = min(
            base.signed_distance(moved.world_points).min(),
            moved.signed_distance(base.world_points).min(),
        )
        assert overlap(moved, base) == max(0.0, -float(every))
