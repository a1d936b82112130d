"""The hand-made features against a naive loop, their invariances, and a case done by hand."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spatial_relations_ros.core import ConfigError, Pose, Scene, SceneObject
from spatial_relations_ros.evaluation.hand_made_features import (
    NUM_FEATURES,
    pair_features,
    scene_features,
    voxel_means,
)


def naive_features(base, relative):
    """The definition, a pair at a time."""
    first, second, distances = np.zeros(18), np.zeros(18), []
    for p1 in base:
        r = p1 - base.mean(axis=0)
        for p2 in relative:
            v = p2 - p1
            distances.append(math.dist(p1, p2))
            for histogram, a, b in (
                (first, r, v),
                (second, np.cross(r, [0, 0, -1.0]), np.cross(v, r)),
            ):
                cosine = a @ b / (np.linalg.norm(a) * np.linalg.norm(b))
                angle = math.degrees(math.acos(min(1.0, max(-1.0, cosine))))
                histogram[min(17, int(angle // 10))] += 1
    distances.sort()
    closest = distances[: max(1, len(distances) // 100)]
    shares = [
        sum(d <= 0.06 for d in closest),
        sum(0.06 < d <= 0.2 for d in closest),
        sum(d > 0.2 for d in closest),
    ]
    return np.concatenate(
        [first / first.sum(), second / second.sum(), np.array(shares) / len(closest)]
    )


@pytest.mark.parametrize('shift', [0.05, 0.25, 0.4])
def test_the_numbers_are_those_of_the_definition(shift):
    rng = np.random.default_rng(1)
    base = rng.uniform(-0.1, 0.1, (40, 3))
    relative = rng.uniform(-0.05, 0.05, (30, 3)) + [shift, 0.0, 0.1]
    np.testing.assert_allclose(
        pair_features(base, relative), naive_features(base, relative), atol=1e-12
    )


def test_a_point_above_a_bar():
    # Along the bar r is (+-0.1, 0, 0), and v rises at 45 degrees towards the middle.
    base = np.array([[-0.1, 0.0, 0.0], [0.1, 0.0, 0.0]])
    features = pair_features(base, np.array([[0.0, 0.0, 0.1]]))
    assert np.flatnonzero(features).tolist() == [13, 18 + 0, 36 + 1]
    # From below, the second angle is the opposite one.
    below = pair_features(base, np.array([[0.0, 0.0, -0.1]]))
    assert np.flatnonzero(below).tolist() == [13, 18 + 17, 36 + 1]


@settings(deadline=None, max_examples=25)
@given(
    st.floats(-math.pi, math.pi),
    st.tuples(*[st.floats(-1.0, 1.0)] * 3),
    st.integers(0, 2**31),
)
def test_moving_the_scene_and_turning_it_about_the_vertical_change_nothing(angle, shift, seed):
    rng = np.random.default_rng(seed)
    base = rng.uniform(-0.1, 0.1, (60, 3))
    relative = rng.uniform(-0.1, 0.1, (60, 3)) + [0.1, 0.0, 0.05]
    motion = Pose(np.array(shift), np.array([np.cos(angle / 2), 0, 0, np.sin(angle / 2)]))
    before = pair_features(base, relative)
    after = pair_features(motion.apply(base), motion.apply(relative))
    # A pair at the very border of a bin may change sides.
    np.testing.assert_allclose(after[:36], before[:36], atol=1.5 / 3600)
    np.testing.assert_allclose(after[36:], before[36:], atol=1.5 / 36)
    assert before[:18].sum() == pytest.approx(1.0)
    assert before[18:36].sum() == pytest.approx(1.0)
    assert before[36:].sum() == pytest.approx(1.0)


def test_a_scene_is_thinned_in_the_objects_frames():
    rng = np.random.default_rng(0)
    points = [rng.uniform(-0.1, 0.1, (5000, 3)).astype(np.float32) for _ in range(2)]
    tilted = Pose(np.array([0.05, 0.0, 0.2]), np.array([0.9, 0.1, 0.3, 0.2]) / np.sqrt(0.95))
    scene = Scene(
        SceneObject('a', points[0], Pose.identity()), SceneObject('b', points[1], tilted)
    )
    features = scene_features(scene)
    expected = pair_features(
        voxel_means(points[0], 0.03), tilted.apply(voxel_means(points[1], 0.03))
    )
    assert features.shape == (NUM_FEATURES,)
    np.testing.assert_array_equal(features, expected)


def test_voxels_hold_the_mean_of_their_points():
    points = np.array([[0.001, 0.0, 0.0], [0.003, 0.0, 0.0], [-0.001, 0.0, 0.0], [0.5, 0.5, 0.5]])
    means = voxel_means(points, 0.03)
    expected = [[-0.001, 0.0, 0.0], [0.002, 0.0, 0.0], [0.5, 0.5, 0.5]]
    np.testing.assert_allclose(sorted(means.tolist()), expected)
    with pytest.raises(ConfigError, match='positive'):
        voxel_means(points, 0.0)


def test_coinciding_points_do_no_harm():
    points = np.zeros((4, 3))
    assert np.isfinite(pair_features(points, points)).all()
