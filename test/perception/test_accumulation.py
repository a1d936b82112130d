"""Memory of what was seen of an object."""

import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.perception.accumulation import AccumulatedCloud, AccumulationConfig

VOXEL = 0.004


def grid(size, start=(0.0, 0.0, 0.0)):
    """Points in the middle of size^3 voxels."""
    axes = np.arange(size) * VOXEL + VOXEL / 2
    return np.stack(np.meshgrid(axes, axes, axes), axis=-1).reshape(-1, 3) + start


def test_a_voxel_counts_once_it_was_seen_often_enough():
    memory = AccumulatedCloud()
    memory.add(grid(4))
    assert (len(memory), len(memory.points)) == (64, 0)
    memory.add(grid(4))
    assert (len(memory), len(memory.points)) == (64, 64)


def test_keeps_one_point_a_voxel_and_averages_jitter():
    rng = np.random.default_rng(0)
    memory = AccumulatedCloud()
    for _ in range(200):
        memory.add(np.repeat(grid(3), 5, axis=0) + rng.normal(0, 0.0003, (135, 3)))
    assert len(memory) == 27
    order = np.lexsort(np.floor(memory.points / VOXEL).T)
    expected = grid(3)[np.lexsort(np.floor(grid(3) / VOXEL).T)]
    np.testing.assert_allclose(memory.points[order], expected, atol=0.0003)


def test_voxels_equal_those_of_a_plain_dictionary():
    rng = np.random.default_rng(1)
    memory, plain = AccumulatedCloud(), {}
    for _ in range(5):
        points = rng.uniform(-0.02, 0.02, (300, 3))
        memory.add(points)
        for key in {tuple(np.floor(point / VOXEL).astype(int)) for point in points}:
            plain[key] = plain.get(key, 0) + 1
    assert len(memory) == len(plain)
    found = {tuple(np.floor(point / VOXEL).astype(int)) for point in memory.points}
    assert found == {key for key, hits in plain.items() if hits >= 2}


def test_only_the_unseen_part_is_added_to_a_live_cloud():
    memory = AccumulatedCloud()
    for _ in range(2):
        memory.add(grid(4))
    live = grid(2)
    unseen = memory.unseen_in(live)
    assert len(unseen) == 64 - 8
    assert not {tuple(p) for p in np.round(unseen, 5)} & {tuple(p) for p in np.round(live, 5)}


def test_what_is_looked_through_is_forgotten():
    memory = AccumulatedCloud(AccumulationConfig(max_hits=5))
    for _ in range(100):
        memory.add(grid(2))
    for num_left in (8, 8, 8, 8, 0):
        memory.miss(np.ones(8, dtype=bool))
        assert len(memory) == num_left
    memory.miss(np.zeros(0, dtype=bool))


def test_memory_is_bounded_and_keeps_what_is_seen_most():
    memory = AccumulatedCloud(AccumulationConfig(max_points=100))
    for _ in range(3):
        memory.add(grid(4))
    for start in range(1, 30):
        memory.add(grid(4, start=(0.1 * start, 0.0, 0.0)))
        assert len(memory) <= 100
    assert len(memory.points) == 64


def test_far_points_do_not_overflow():
    memory = AccumulatedCloud()
    memory.add(np.array([[1e30, -1e30, 0.0], [np.finfo(np.float32).max, 0.0, 0.0]]))
    assert len(memory) == 2


@pytest.mark.parametrize('wrong', [{'voxel': 0.0}, {'min_hits': 50}, {'min_consistency': 2.0}])
def test_refuses_impossible_settings(wrong):
    with pytest.raises(ConfigError):
        AccumulationConfig(**wrong)
