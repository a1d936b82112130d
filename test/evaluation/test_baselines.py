import warnings

import numpy as np
import pytest

from spatial_relations_ros.evaluation.baselines import (
    EUCLIDEAN,
    LMNN,
    compare_baselines,
    lmnn_space,
    standardised,
)
from spatial_relations_ros.evaluation.labelled_scenes import LabelledScenes


@pytest.fixture
def noisy():
    """Two informative numbers among ten, of which the others are louder."""
    rng = np.random.default_rng(0)
    labels = np.repeat(np.arange(3), 40)
    features = rng.normal(size=(120, 10))
    features[:, :2] = 0.3 * features[:, :2] + np.array([[0, 0], [1, 0], [0, 1]])[labels]
    return features, labels, rng.permutation(120)[:90]


def share_of_right_neighbours(space, labels, gallery):
    queries = np.setdiff1d(np.arange(len(labels)), gallery)
    gaps = np.linalg.norm(space[queries][:, None] - space[gallery], axis=-1)
    return (labels[gallery][gaps.argmin(axis=1)] == labels[queries]).mean()


def test_lmnn_learns_which_features_matter_from_the_gallery_alone(noisy):
    features, labels, gallery = noisy
    with warnings.catch_warnings():
        warnings.simplefilter('error', FutureWarning)
        space = lmnn_space(features, gallery, labels)
    before = share_of_right_neighbours(features, labels, gallery)
    assert share_of_right_neighbours(space, labels, gallery) > before + 0.1
    spoilt = labels.copy()
    spoilt[np.setdiff1d(np.arange(120), gallery)] = 0
    np.testing.assert_array_equal(lmnn_space(features, gallery, spoilt), space)


def test_lmnn_of_lonely_scenes_changes_nothing(noisy):
    features, _, gallery = noisy
    assert lmnn_space(features, gallery[:3], np.arange(120)) is features


def test_features_are_scaled_by_the_gallery_alone():
    rng = np.random.default_rng(0)
    features, gallery = rng.uniform(size=(50, 4)), np.arange(30)
    features[:, 3] = 0.25
    scaled = standardised(features, gallery)
    np.testing.assert_allclose(scaled[gallery].mean(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(scaled[gallery][:, :3].std(axis=0), 1.0)
    assert (scaled[:, 3] == 0.0).all()
    features[40:] *= 0.5
    np.testing.assert_array_equal(standardised(features, gallery)[gallery], scaled[gallery])


def test_every_baseline_runs_over_every_split(relation_scenes):
    scenes = LabelledScenes.of(relation_scenes)
    steps = []
    compared = compare_baselines(
        (EUCLIDEAN, LMNN), scenes, ('scene',), on_progress=lambda *step: steps.append(step)
    )
    assert [item.name for item in compared] == [EUCLIDEAN, LMNN]
    assert steps[-1] == (len(scenes.entries) + 2, len(scenes.entries) + 2)
    for item in compared:
        assert len(item.reports['scene'].results) == 2
        # Boxes far above or beside each other: plain geometry tells them apart.
        assert item.reports['scene'].summary()['three_of_five'] == 1.0
    assert compare_baselines((), scenes, ('scene',)) == []
