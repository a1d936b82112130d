"""Several metrics on the same splits, their tables and their pictures."""

import dataclasses

import numpy as np
import pytest
import torch

from spatial_relations_ros.core import DatasetFormatError
from spatial_relations_ros.datasets.freiburg import Split
from spatial_relations_ros.evaluation.baselines import EUCLIDEAN, compare_baselines
from spatial_relations_ros.evaluation.comparison import (
    MEASURES,
    calibration_entries,
    compare_metric,
    protocols_of,
    seed_groups,
)
from spatial_relations_ros.evaluation.labelled_scenes import LabelledScenes
from spatial_relations_ros.evaluation.retrieval_pictures import (
    worst_first,
    write_retrieval_pictures,
)
from spatial_relations_ros.evaluation.retrieval_tables import COLUMNS, markdown_table, table_rows
from spatial_relations_ros.evaluation.splits_report import evaluate_splits, retrieve
from spatial_relations_ros.learning import Calibration, ModelCard, RelationMetric, make_encoder
from spatial_relations_ros.visualization import read_image


def make_metric(seed, *, encoder='compact', calibration=None):
    torch.manual_seed(seed)
    card = ModelCard(encoder, num_points=256, config={'name': 'tiny', 'seed': seed, 'steps': 0})
    return RelationMetric(make_encoder(encoder), card, calibration)


@pytest.fixture(scope='module')
def scenes(relation_scenes):
    return LabelledScenes.of(relation_scenes)


@pytest.fixture(scope='module')
def compared(scenes):
    learned = [compare_metric(f'seed {s}', make_metric(s), scenes, ('scene',)) for s in (0, 1)]
    return [*learned, *compare_baselines((EUCLIDEAN,), scenes, ('scene',))]


def test_a_comparison_has_the_numbers_that_retrieve_has(compared, relation_scenes):
    alone = retrieve(make_metric(0), relation_scenes)
    assert compared[0].reports['scene'].summary() == alone.summary()
    entry = compared[0].entry()
    assert (entry['kind'], entry['config'], entry['seed']) == ('weights', 'tiny', 0)
    assert entry['protocols']['scene']['num_queries'] == 8


def test_copies_of_the_same_weights_are_no_two_seeds(compared):
    copy = dataclasses.replace(compared[0], name='copy')
    assert seed_groups([compared[0], copy]) == []
    (group,) = seed_groups([copy, *compared])
    assert group['seeds'] == [0, 1]


def test_spread_over_seeds_is_that_of_the_members(compared):
    (group,) = seed_groups(compared)
    assert group['names'] == ['seed 0', 'seed 1']
    assert group['seeds'] == [0, 1]
    for measure in MEASURES:
        values = [item.reports['scene'].summary()[measure] for item in compared[:2]]
        numbers = group['protocols']['scene']
        assert numbers[measure] == pytest.approx(np.mean(values), abs=1e-4)
        assert numbers[f'{measure}_std_over_seeds'] == pytest.approx(
            np.std(values, ddof=1), abs=1e-4
        )


def test_other_configurations_are_no_seeds_of_each_other(scenes, compared):
    other = make_metric(5)
    config = {**other.card.config, 'steps': 1}
    other.card = dataclasses.replace(other.card, config=config)
    assert seed_groups([compared[0], compare_metric('x', other, scenes, ('scene',))]) == []


def test_tables_hold_every_metric_and_the_seeds(compared):
    groups = seed_groups(compared)
    columns, rows = table_rows(compared, groups)
    assert columns == COLUMNS
    assert [row[0] for row in rows] == [
        'seed 0', 'seed 1', 'hand-made features, Euclidean', 'mean of seed 0, seed 1',
    ]  # fmt: skip
    assert all(len(row) == len(columns) for row in rows)
    lines = markdown_table(compared, groups).splitlines()
    assert len(lines) == 2 + len(rows)
    assert {line.count('|') for line in lines} == {6}
    assert '100.0 %' in lines[4]


def test_a_space_is_fitted_to_the_training_rows_of_each_split(scenes, relation_scenes):
    seen = []

    def space(gallery):
        seen.append(sorted(gallery.tolist()))
        return np.eye(3)[scenes.labels]

    report = evaluate_splits(space, scenes, relation_scenes.splits, protocol='scene')
    assert seen == [list(range(12)), list(range(4, 16))]
    assert report.summary()['three_of_five'] == 1.0


def test_protocols_follow_the_splits_that_are_there(relation_scenes):
    assert protocols_of(relation_scenes, 'both') == ('scene',)
    with pytest.raises(DatasetFormatError, match='no object splits'):
        protocols_of(relation_scenes, 'object')
    bare = dataclasses.replace(relation_scenes, splits=())
    with pytest.raises(DatasetFormatError, match='has no splits'):
        protocols_of(bare, 'both')
    split = Split('split1', ('a',), ('b',))
    both = dataclasses.replace(relation_scenes, object_splits=(split,))
    assert protocols_of(both, 'both') == ('scene', 'object')


def test_calibrations_are_measured_where_there_are_any(scenes, compared):
    plain = make_metric(0)
    embeddings = plain.embed_scenes([scenes.scene(0)])
    calibration = Calibration(np.array([0.0, 1.0]), np.array([0.9, 0.1]), embeddings, 1e9)
    metric = make_metric(0, calibration=calibration)
    metric.card = dataclasses.replace(metric.card, calibration={'data': {'scenes_sha256': 'a'}})
    items = [*compared, compare_metric('calibrated', metric, scenes, ('scene',))]
    entries = calibration_entries(items, scenes, scenes_sha256='a', seed=0, num_nonsense=2)
    assert list(entries) == ['calibrated']
    assert entries['calibrated']['fitted_on_this_data']
    assert entries['calibrated']['novelty']['false_alarms'] == 0.0
    assert set(entries['calibrated']['novelty']['num_nonsense'].values()) == {2}
    assert calibration_entries(compared, scenes, scenes_sha256='a', seed=0) == {}


def test_worst_queries_come_first_and_relations_take_turns():
    hits, labels = np.array([5, 1, 1, 1, 0, 5]), np.array([0, 0, 0, 1, 1, 1])
    assert worst_first(hits, labels) == [4, 1, 2, 3, 0, 5]


def test_pictures_of_every_metric_are_written(compared, scenes, tmp_path):
    rendered = []
    paths = write_retrieval_pictures(
        tmp_path, [compared[0], compared[2]], scenes, seed=0,
        on_picture=lambda done, total: rendered.append((done, total)),
    )  # fmt: skip
    assert sorted(path.name for path in paths) == [
        'mees2017_euclidean_scene_confusion.png', 'seed_0_map.png', 'seed_0_neighbours.png',
        'seed_0_scene_confusion.png',
    ]  # fmt: skip
    # Each scene is drawn once, however often it is shown.
    assert len(rendered) <= len(scenes.entries)
    for path in paths:
        assert read_image(path).std() > 5.0
