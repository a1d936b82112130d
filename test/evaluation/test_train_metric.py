"""From a dataset folder to weights with a card, and back to the card's numbers."""

import shutil

import pytest

from spatial_relations_ros.core import ConfigError, DatasetFormatError, WeightsError
from spatial_relations_ros.datasets.freiburg import load_dataset
from spatial_relations_ros.datasets.generator import generate_dataset
from spatial_relations_ros.evaluation.gradients import VARIANTS, compare_gradients
from spatial_relations_ros.evaluation.splits_report import retrieve
from spatial_relations_ros.evaluation.training import measure_retrieval, train_metric
from spatial_relations_ros.learning import load_metric
from spatial_relations_ros.visualization import read_image


@pytest.fixture(scope='module')
def data(tmp_path_factory):
    folder = tmp_path_factory.mktemp('data') / 'generated'
    generate_dataset(folder, num_scenes=70, num_objects=40, seed=3)
    return folder


@pytest.fixture(scope='module')
def other_data(tmp_path_factory):
    folder = tmp_path_factory.mktemp('data') / 'other'
    generate_dataset(folder, num_scenes=70, num_objects=40, seed=4)
    return folder


def test_training_writes_weights_whose_card_tells_the_truth(data, other_data, tmp_path):
    out = tmp_path / 'weights.safetensors'
    card = train_metric(data, out, steps=3, held_out_dir=other_data, run_dir=tmp_path / 'run')
    assert card.steps == 3
    assert card.config['name'] == 'default'
    assert card.data['num_scenes'] == 70
    losses = read_image(tmp_path / 'run' / 'losses.png')
    assert losses.shape[2] == 3
    metric = load_metric(out)
    assert metric.card == card
    assert metric.calibration is not None
    assert card.calibration['same_relation_distance'] == pytest.approx(
        metric.calibration.same_relation_distance, abs=1e-4
    )
    again = measure_retrieval(out, other_data, 'scene').summary()
    assert {key: card.retrieval[key] for key in again} == again


def test_without_other_data_a_split_is_held_out(data, tmp_path):
    card = train_metric(data, tmp_path / 'weights.safetensors', steps=2, device='cpu')
    dataset = load_dataset(data)
    split = (*dataset.object_splits, *dataset.splits)[0]
    assert card.retrieval['split'] == f'scene {split.name}'
    assert card.retrieval['protocol'] == '1 scene split'
    assert card.retrieval['three_of_five_std'] is None
    assert card.data['num_scenes'] == len(split.train)


def test_scenes_that_are_trained_with_are_not_held_out(data, tmp_path):
    copy = tmp_path / 'copy'
    shutil.copytree(data, copy)
    with pytest.raises(DatasetFormatError, match='which are trained with; name scenes of other'):
        train_metric(data, tmp_path / 'w.safetensors', steps=1, held_out_dir=copy)


def test_the_shipped_metric_retrieves_generated_scenes_far_above_chance(data):
    report = retrieve(load_metric(), load_dataset(data))
    # 70 scenes only, so neighbours are few; chance is one in seven.
    assert report.summary()['mean_average_precision'] > 0.5
    assert report.confusion.sum() == report.summary()['num_queries']


def test_the_silhouette_gradient_agrees_with_finite_differences_of_the_metric(data):
    report = compare_gradients(
        load_metric(), load_dataset(data), num_cases=12, seed=0, variants=VARIANTS[:1], steps=1
    )
    agreement = report['silhouette']['agreement']
    assert agreement['shift']['correlation'] > 0.7
    assert agreement['turn']['equal_sign'] > 0.6


def test_an_unknown_protocol_or_configuration_is_told(data, tmp_path):
    with pytest.raises(DatasetFormatError, match='no class splits'):
        retrieve(load_metric(), load_dataset(data), protocol='class')
    with pytest.raises(ConfigError, match='no configuration'):
        train_metric(data, tmp_path / 'weights.safetensors', config_name='best')


def test_held_out_data_without_splits_is_refused_before_training(data, tmp_path):
    bare = tmp_path / 'bare'
    shutil.copytree(data, bare)
    shutil.rmtree(bare / 'cross_validation_splits')
    steps = []
    with pytest.raises(DatasetFormatError, match='no scene splits'):
        train_metric(
            data, tmp_path / 'w.safetensors', steps=1, held_out_dir=bare, on_progress=steps.append
        )
    assert steps == []


def test_weights_without_finite_embeddings_are_not_written(data, tmp_path):
    out = tmp_path / 'weights.safetensors'
    with pytest.raises(WeightsError, match='not finite; train with a smaller learning rate'):
        train_metric(data, out, steps=1, changes={'learning_rate': 1e38})
    assert not out.exists()


def test_a_split_over_objects_is_called_so(tmp_path):
    folder = tmp_path / 'data'
    generate_dataset(folder, num_scenes=56, num_objects=48, seed=3)
    card = train_metric(folder, tmp_path / 'weights.safetensors', steps=1, device='cpu')
    assert card.retrieval['split'] == 'object split1'
    assert card.retrieval['protocol'] == '1 object split'
    dataset = load_dataset(folder)
    trained = [dataset.scene_by_name[name] for name in dataset.object_splits[0].train]
    assert card.data['num_scenes'] == len(trained)
    objects = {one for scene in trained for one in (scene.base_id, scene.relative_id)}
    assert card.data['num_objects'] == len(objects) < len(dataset.clouds)


def without_labels(folder):
    (folder / 'labels.tsv').unlink()


def with_one_label(folder):
    lines = (folder / 'labels.tsv').read_text().splitlines()[:2]
    (folder / 'labels.tsv').write_text('\n'.join(lines))


def with_damaged_description(folder):
    (folder / 'dataset.json').write_text('{')


@pytest.mark.parametrize(
    ('damage', 'complaint'),
    [
        (without_labels, 'scene split1: 0 test and 0 training scenes with labels'),
        (with_one_label, r'scene split1: \d test and \d training scenes with labels'),
        (with_damaged_description, 'dataset.json is not JSON'),
    ],
)
def test_trouble_with_held_out_data_is_told_before_training(
    data, other_data, tmp_path, damage, complaint
):
    other = tmp_path / 'other'
    shutil.copytree(other_data, other)
    damage(other)
    steps = []
    with pytest.raises(DatasetFormatError, match=complaint):
        train_metric(
            data, tmp_path / 'w.safetensors', steps=1, held_out_dir=other, on_progress=steps.append
        )
    assert steps == []
