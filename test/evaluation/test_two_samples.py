"""Distances between samples: alike, apart, and against the definition."""

import numpy as np
import pytest

from spatial_relations_ros.evaluation.two_samples import (
    classifier_accuracy,
    covered,
    energy_distance,
    nearest_distances,
    spacing,
)


@pytest.fixture
def rng():
    return np.random.default_rng(0)


def test_samples_of_one_distribution_are_at_chance(rng):
    first, second = rng.normal(size=(150, 4)), rng.normal(size=(100, 4))
    energy = energy_distance(first, second, rng)
    assert energy.share < energy.chance_95 * 1.5
    mean, std = classifier_accuracy(first, second, seed=0)
    assert mean == pytest.approx(0.5, abs=0.12)
    assert 0.0 < std < 0.2
    assert covered(first, second).mean() == pytest.approx(0.9, abs=0.1)


def test_shifted_samples_are_told_apart(rng):
    first, second = rng.normal(size=(150, 4)), rng.normal(size=(100, 4)) + 6.0
    energy = energy_distance(first, second, rng)
    assert energy.share > 0.3 > energy.chance_95
    assert classifier_accuracy(first, second, seed=0)[0] > 0.95
    assert covered(first, second).mean() < 0.05


def test_a_part_is_covered_by_the_whole_and_not_the_other_way(rng):
    whole = rng.uniform(0.0, 1.0, (400, 2))
    part = rng.uniform(0.0, 0.4, (100, 2))
    assert covered(part, whole).mean() > 0.8
    assert covered(whole, part).mean() < 0.5


def test_energy_distance_is_that_of_the_definition(rng):
    first, second = rng.normal(size=(7, 3)), rng.normal(size=(5, 3)) + 1.0

    def mean(a, b):
        return np.mean([[np.linalg.norm(x - y) for y in b] for x in a])

    expected = 1.0 - (mean(first, first) + mean(second, second)) / (2.0 * mean(first, second))
    assert energy_distance(first, second, rng).share == pytest.approx(expected)


def test_nearest_distances_and_spacing():
    line = np.array([[0.0], [1.0], [3.0]])
    assert nearest_distances(np.array([[2.5]]), line).tolist() == [0.5]
    assert spacing(line).tolist() == [1.0, 1.0, 2.0]
