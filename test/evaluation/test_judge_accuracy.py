"""The judge's accuracy on generated scenes, as the command reports it."""

import dataclasses
import json

import pytest

from spatial_relations_ros.core import DatasetFormatError, Relation
from spatial_relations_ros.datasets.freiburg import load_dataset, write_dataset
from spatial_relations_ros.datasets.generator import generate_dataset
from spatial_relations_ros.evaluation.judge_accuracy import judge_dataset, main


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp('judged')
    generate_dataset(path, num_scenes=28, num_objects=30, seed=5, num_points=64)
    return path


def test_the_command_reports_what_the_judge_gets_right(folder, tmp_path, capsys):
    assert main([str(folder), '--json', str(tmp_path / 'report.json')]) == 0
    report = json.loads((tmp_path / 'report.json').read_text())
    table = report['accuracy']
    assert table['all']['scenes'] == 28
    assert table['all']['right'] >= 26
    assert sum(table[relation.name]['right'] for relation in Relation) == table['all']['right']
    assert sum(report['confusions'].values()) == 28 - table['all']['right']
    assert f'{table["all"]["right"]} of 28' in capsys.readouterr().out


def test_wrong_labels_lower_the_accuracy_and_are_drawn(folder, tmp_path):
    dataset = load_dataset(folder)
    scenes = [
        dataclasses.replace(scene, label=Relation((int(scene.label) + 1) % len(Relation)))
        for scene in dataset.scenes[:4]
    ]
    write_dataset(
        tmp_path / 'wrong', dataclasses.replace(dataset, scenes=tuple(scenes), splits=())
    )
    main([str(tmp_path / 'wrong'), '--pictures', str(tmp_path / 'wrong.png'), '--scenes', '3'])
    judged = judge_dataset(load_dataset(tmp_path / 'wrong'))
    assert sum(scene.is_right for scene in judged) <= 1
    assert (tmp_path / 'wrong.png').stat().st_size > 10_000


def test_datasets_without_meshes_are_refused(folder):
    dataset = dataclasses.replace(load_dataset(folder), meshes={})
    with pytest.raises(DatasetFormatError, match='none of the 28 scenes has a label and meshes'):
        judge_dataset(dataset)
