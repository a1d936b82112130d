"""Whole generated folders: repeatable, balanced, in the paper's format."""

from __future__ import annotations

import errno
import hashlib
import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError, DatasetFormatError, Relation
from spatial_relations_ros.datasets.freiburg import RelationDataset, load_dataset
from spatial_relations_ros.datasets.freiburg.writing import write_lines
from spatial_relations_ros.datasets.generator import generate_dataset, generate_objects
from spatial_relations_ros.datasets.objects import CONTAINER_FAMILIES, OBJECT_FAMILIES

NUM_SCENES, NUM_OBJECTS = 28, 48


@pytest.fixture(scope='module')
def folder(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp('generated') / 'data'
    generate_dataset(
        folder, num_scenes=NUM_SCENES, num_objects=NUM_OBJECTS, seed=3, num_points=4096
    )
    return folder


@pytest.fixture(scope='module')
def dataset(folder) -> RelationDataset:
    return load_dataset(folder)


def digest(folder: Path) -> dict[str, str]:
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob('*'))
        if path.is_file()
    }


def test_same_seed_same_bytes_with_any_number_of_processes(tmp_path):
    progress = []
    for name, num_jobs in (('a', 1), ('b', 2)):
        generate_dataset(
            tmp_path / name,
            num_scenes=28,
            num_objects=20,
            seed=5,
            num_points=100,
            on_progress=lambda done, total: progress.append((done, total)),
            num_jobs=num_jobs,
        )
    assert digest(tmp_path / 'a') == digest(tmp_path / 'b')
    assert progress == [(done, 28) for done in range(1, 29)] * 2


def test_other_seed_other_objects():
    first, second = (generate_objects(12, seed=seed) for seed in (5, 6))
    assert [dict(model.dimensions) for model in first] != [dict(m.dimensions) for m in second]
    assert [model.name for model in first] != [model.name for model in second]


def test_labels_are_balanced(dataset):
    assert Counter(scene.label for scene in dataset.scenes) == dict.fromkeys(
        Relation, NUM_SCENES // 7
    )


def test_clouds_and_meshes_of_every_used_object(dataset):
    for name, points in dataset.clouds.items():
        assert points.shape == (4096, 3)
        extents = np.ptp(dataset.meshes[name].vertices, axis=0)
        np.testing.assert_allclose(np.ptp(points, axis=0), extents, atol=0.01)
        assert '_' not in name


def test_splits_over_scenes(dataset):
    names = {scene.name for scene in dataset.scenes}
    assert len(dataset.splits) == 15
    assert len({split.test for split in dataset.splits}) == 15
    for split in dataset.splits:
        assert set(split.train) | set(split.test) == names
        assert not set(split.train) & set(split.test)
        labels = Counter(dataset.scene_by_name[name].label for name in split.test)
        assert labels == dict.fromkeys(Relation, 1)


def test_splits_over_objects_share_no_object(dataset):
    assert len(dataset.object_splits) >= 2
    for split in dataset.object_splits:
        train, test = (
            {
                object_id
                for name in part
                for object_id in (
                    dataset.scene_by_name[name].base_id,
                    dataset.scene_by_name[name].relative_id,
                )
            }
            for part in (split.train, split.test)
        )
        assert train
        assert test
        assert not train & test


def test_ground_truth_agrees_with_the_scenes(folder, dataset):
    lines = (folder / 'ground_truth.jsonl').read_text().splitlines()
    assert len(lines) == NUM_SCENES
    for line in lines:
        truth = json.loads(line)
        entry = dataset.scene_by_name[truth['scene']]
        scene = dataset.scene_of(entry)
        assert entry.label == truth['relation']
        lowest = entry.world_from_base.apply(dataset.meshes[entry.base_id].vertices)[:, 2].min()
        assert truth['table_height'] == pytest.approx(lowest, abs=1e-4)
        assert truth['tilt_rad'] == pytest.approx(
            np.arccos(np.clip(entry.world_from_relative.rotation[2, 2], -1, 1)), abs=1e-4
        )
        assert scene.base.world_points[:, 2].min() > truth['table_height'] - 1e-3
        assert scene.relative.world_points[:, 2].min() > truth['table_height'] - 1e-3
        assert np.isfinite(truth['clearance'])
        assert all(count > 0 for count in truth['rejected'].values())


def test_refused_candidates_are_counted(folder):
    rejected = json.loads((folder / 'dataset.json').read_text())['rejected']
    assert list(rejected) == [relation.name.lower() for relation in Relation]
    truths = [json.loads(line) for line in (folder / 'ground_truth.jsonl').open()]
    total = sum(sum(truth['rejected'].values()) for truth in truths)
    assert sum(sum(reasons.values()) for reasons in rejected.values()) == total > 0


def test_objects_are_described(folder, dataset):
    described = json.loads((folder / 'objects.json').read_text())
    assert len(described) == NUM_OBJECTS
    families = {entry['family'] for entry in described.values()}
    assert len(families) == NUM_OBJECTS
    assert families < set(OBJECT_FAMILIES)
    assert len(families & set(CONTAINER_FAMILIES)) >= NUM_OBJECTS // 4
    assert set(dataset.clouds) <= set(described)
    assert all(0.0 < value < 0.5 for o in described.values() for value in o['dimensions'].values())


@pytest.mark.parametrize(
    'wrong',
    [{'num_scenes': 27}, {'num_objects': 9}, {'num_points': 3}, {'seed': -1}, {'num_jobs': 0}],
)
def test_numbers_that_are_too_small(tmp_path, wrong):
    arguments = {'num_scenes': 28, 'num_objects': 20, 'seed': 0, 'num_points': 10} | wrong
    with pytest.raises(ConfigError, match='are needed'):
        generate_dataset(tmp_path, **arguments)


def test_a_smaller_dataset_replaces_a_larger_one_wholly(tmp_path):
    for folder, num_objects in (('used', 48), ('used', 12), ('fresh', 12)):
        generate_dataset(
            tmp_path / folder, num_scenes=28, num_objects=num_objects, seed=5, num_points=100
        )
    assert digest(tmp_path / 'used') == digest(tmp_path / 'fresh')
    assert len(load_dataset(tmp_path / 'used').splits) == 15


def test_what_was_not_generated_is_not_replaced(tmp_path):
    (tmp_path / 'scenes.txt').write_text('name\n')
    steps = []
    with pytest.raises(ConfigError, match='were not generated; choose another folder'):
        generate_dataset(
            tmp_path, num_scenes=28, num_objects=12, seed=5,
            on_progress=lambda *done: steps.append(done),
        )  # fmt: skip
    assert steps == []
    assert [path.name for path in tmp_path.iterdir()] == ['scenes.txt']


def test_one_that_was_not_written_to_the_end_is_replaced(tmp_path):
    """Killed after any file, it is known as generated and replaced by the same command."""
    arguments = {'num_scenes': 28, 'num_objects': 12, 'seed': 5, 'num_points': 100}
    generate_dataset(tmp_path / 'whole', **arguments)
    for name in ('scenes.txt', 'ground_truth.jsonl', 'objects.json'):
        generate_dataset(tmp_path / 'half', **arguments)
        (tmp_path / 'half' / name).unlink()
        generate_dataset(tmp_path / 'half', **arguments)
        assert digest(tmp_path / 'half') == digest(tmp_path / 'whole')


@pytest.mark.parametrize(
    'last', ['ground_truth.jsonl', 'labels.tsv', 'split5_train.txt', 'scenes.txt']
)
def test_one_that_is_half_replaced_is_no_dataset(tmp_path, monkeypatch, last):
    """Rather than the scenes of one with clouds, labels or ground truth of another."""
    arguments = {'num_scenes': 28, 'num_objects': 12, 'num_points': 100}
    generate_dataset(tmp_path / 'new', **arguments, seed=6)
    generate_dataset(tmp_path / 'old', **arguments, seed=5)

    def full(path, lines):
        if path.name == last:
            raise OSError(errno.ENOSPC, 'no space left')
        write_lines(path, lines)

    with monkeypatch.context() as patch:
        for module in ('datasets.freiburg.writing', 'datasets.generator.writing'):
            patch.setattr(f'spatial_relations_ros.{module}.write_lines', full)
        with pytest.raises(OSError, match='no space left'):
            generate_dataset(tmp_path / 'old', **arguments, seed=6)
    with pytest.raises(DatasetFormatError, match=r'holds no scenes\.txt'):
        load_dataset(tmp_path / 'old')
    generate_dataset(tmp_path / 'old', **arguments, seed=6)
    assert digest(tmp_path / 'old') == digest(tmp_path / 'new')
