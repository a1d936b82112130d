"""Calibrations of embeddings whose truth is known."""

import numpy as np
import pytest

from spatial_relations_ros.core import Pose, Relation
from spatial_relations_ros.datasets.freiburg import RelationDataset, RelationScene
from spatial_relations_ros.evaluation.calibrating import (
    Pairs,
    fit_calibration,
    measure_calibration,
    measure_reliability,
)
from spatial_relations_ros.evaluation.labelled_scenes import thin_rows
from spatial_relations_ros.evaluation.nonsense import KINDS, MIN_OVERLAP, nonsense_scenes
from spatial_relations_ros.imitation.contact import Body, overlap, reach_through
from spatial_relations_ros.imitation.shape import shape_of


@pytest.mark.parametrize('num', [10_490, 10_494, 9_000])
def test_thinned_rows_have_all_labels_also_where_these_repeat_in_step(num):
    labels = np.arange(num) % len(Relation)
    rows = thin_rows(labels, 1500)
    assert len(np.unique(rows)) == len(rows) == 1500
    assert np.all(np.abs(np.bincount(labels[rows]) - 1500 / len(Relation)) < 22)
    assert np.ptp(np.diff(np.concatenate([[0], rows, [num - 1]]))) < 25


def clouds_of_points(seed, *, num=300, spread=0.35):
    """Seven relations around corners that are 1.4 apart, in 8 dimensions."""
    rng = np.random.default_rng(seed)
    labels = rng.integers(0, len(Relation), num)
    return np.eye(8)[labels] + spread * rng.normal(size=(num, 8)), labels


@pytest.fixture(scope='module')
def calibration():
    return fit_calibration(*clouds_of_points(0, num=700), *clouds_of_points(1, num=500))


def test_pairs_of_both_kinds_weigh_one_half_each():
    embeddings, labels = clouds_of_points(3, num=40)
    pairs = Pairs.of(embeddings, labels)
    assert pairs.weights[pairs.same].sum() == pytest.approx(0.5)
    assert pairs.weights[~pairs.same].sum() == pytest.approx(0.5)
    first, second = np.triu_indices(40, 1)
    naive = [
        np.linalg.norm(embeddings[i] - embeddings[k]) for i, k in zip(first, second, strict=True)
    ]
    np.testing.assert_allclose(pairs.distances, naive)
    assert Pairs.of(embeddings, np.zeros(40, int)) is None
    assert Pairs.of(embeddings[:2], np.array([0, 1])) is None


def test_probabilities_fall_with_the_distance_and_come_true_on_other_scenes(calibration):
    assert (np.diff(calibration.probabilities) <= 0.0).all()
    assert calibration.same_relation_probability(0.2) > 0.9
    assert calibration.same_relation_probability(3.0) < 0.1
    reliability = measure_reliability(calibration, *clouds_of_points(2, num=500))
    assert reliability['expected_calibration_error'] < 0.05
    assert reliability['accuracy'] > 0.7
    assert sum(bin_['share'] for bin_ in reliability['bins']) == pytest.approx(1.0, abs=0.01)


def test_a_calibration_of_other_embeddings_is_found_out(calibration):
    embeddings, labels = clouds_of_points(2, num=200)
    right = measure_reliability(calibration, embeddings, labels)
    wrong = measure_reliability(calibration, 0.6 * embeddings, labels)
    assert wrong['expected_calibration_error'] > right['expected_calibration_error'] + 0.1


def test_one_in_a_hundred_real_scenes_is_novel_and_strangers_are(calibration):
    embeddings, labels = clouds_of_points(2, num=500)
    far, near = 5.0 + embeddings[:50], embeddings[50:100]
    entry = measure_calibration(calibration, embeddings, labels, {'far': far, 'near': near})
    assert entry['novelty']['false_alarms'] < 0.05
    assert entry['novelty']['detected'] == {
        'far': 1.0,
        'near': pytest.approx((calibration.novelty(near) > 1.0).mean()),
    }
    assert entry['novelty']['detected_at_1_percent']['far'] == 1.0
    assert entry['novelty']['detected_at_1_percent']['near'] <= 0.1
    assert entry['num_prototypes'] == len(calibration.prototypes) == 7 * 32


def test_nothing_to_tell_apart_gives_no_calibration():
    embeddings, labels = clouds_of_points(0, num=60)
    assert fit_calibration(embeddings, labels, embeddings, np.zeros(60, int)) is None


def test_nonsense_is_nonsense_and_repeats(solids):
    base, relative = (
        solids.box('base', (0.2, 0.2, 0.1), (0, 0, 0)),
        solids.cup('cup', 0.04, 0.09, (0, 0, 0)),
    )
    dataset = RelationDataset(
        {item.object_id: item.points for item in (base, relative)},
        (
            RelationScene(
                'base_cup_0', 'base', 'cup', Pose(), Pose(np.array([0, 0, 0.095])), Relation(0)
            ),
        ),
        meshes={item.object_id: item.mesh for item in (base, relative)},
    )
    scenes = nonsense_scenes(dataset, num_each=3, seed=0)
    assert tuple(scenes) == KINDS
    for scene in scenes['interpenetrating']:
        bodies = [Body(shape_of(item), item.world_from_object) for item in scene.objects]
        assert max(overlap(*bodies), reach_through(*bodies)) >= MIN_OVERLAP
    for scene in scenes['floating']:
        gap = scene.relative.world_points[:, 2].min() - scene.base.world_points[:, 2].max()
        assert 0.049 < gap < 0.301
    for scene in scenes['far_apart']:
        offset = scene.relative.world_points.mean(axis=0) - scene.base.world_points.mean(axis=0)
        assert np.linalg.norm(offset[:2]) == pytest.approx(1.0, abs=0.05)
        lows = [item.world_points[:, 2].min() for item in scene.objects]
        assert lows[0] == pytest.approx(lows[1], abs=1e-5)
    again = nonsense_scenes(dataset, num_each=3, seed=0)
    for kind in KINDS:
        for one, other in zip(scenes[kind], again[kind], strict=True):
            assert one.relative.world_from_object.is_close(other.relative.world_from_object)
