"""Damaged dataset folders: a named error with the file, or a dataset that is whole."""

from __future__ import annotations

import dataclasses
import shutil
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spatial_relations_ros.core import CloudFormatError, DatasetFormatError, Pose, Relation
from spatial_relations_ros.datasets.freiburg import (
    RelationDataset,
    RelationScene,
    Split,
    load_dataset,
    read_labels,
    write_dataset,
)
from spatial_relations_ros.datasets.freiburg.lines import read_scene_names
from spatial_relations_ros.datasets.object_files import load_object_model

moderate = settings(deadline=None, max_examples=40)
TEXT_FILES = (
    'scenes.txt',
    'labels.tsv',
    'cross_validation_splits/split1_train.txt',
    'cross_validation_splits/split1_test.txt',
)


@pytest.fixture(scope='module')
def whole(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp('whole') / 'data'
    rng = np.random.default_rng(0)
    names = tuple(f'cup_box_{number}' for number in range(4))
    scenes = tuple(
        RelationScene(name, 'cup', 'box', Pose(), Pose(rng.normal(size=3) * 0.1), Relation(k))
        for k, name in enumerate(names)
    )
    clouds = {name: (0.1 * rng.normal(size=(40, 3))).astype(np.float32) for name in ('cup', 'box')}
    splits = (Split('split1', names[:3], names[3:]),)
    write_dataset(folder, RelationDataset(clouds, scenes, splits))
    return folder


@pytest.fixture(scope='module')
def copy(whole, tmp_path_factory) -> Path:
    return Path(shutil.copytree(whole, tmp_path_factory.mktemp('copies') / 'data'))


def loaded_or_complaint(folder: Path) -> RelationDataset | str:
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')
        try:
            return load_dataset(folder)
        except DatasetFormatError as error:
            return str(error)


def check(folder: Path) -> None:
    """The outcome is a dataset without holes, or a complaint that names a file."""
    outcome = loaded_or_complaint(folder)
    if isinstance(outcome, str):
        assert str(folder) in outcome
        return
    for scene in outcome.scenes:
        assert {scene.base_id, scene.relative_id} <= set(outcome.clouds)
        assert np.isfinite(scene.world_from_relative.as_matrix()).all()
        assert scene.label is None or scene.label in Relation
    known = {scene.name for scene in outcome.scenes}
    for split in outcome.splits:
        assert split.train
        assert split.test
        assert set(split.train) | set(split.test) <= known


@moderate
@given(st.sampled_from(TEXT_FILES), st.data())
def test_a_changed_piece_of_text(whole, copy, name, data):
    text = (whole / name).read_text()
    start = data.draw(st.integers(0, len(text) - 1))
    length = data.draw(st.integers(0, 12))
    new = data.draw(st.text(alphabet=';,:_\t\n #-.0123456789aenxf', max_size=8))
    (copy / name).write_text(text[:start] + new + text[start + length :])
    try:
        check(copy)
    finally:
        (copy / name).write_text(text)


@moderate
@given(st.sampled_from(TEXT_FILES), st.binary(max_size=80))
def test_any_bytes_instead_of_text(whole, copy, name, content):
    original = (whole / name).read_bytes()
    (copy / name).write_bytes(content)
    try:
        check(copy)
    finally:
        (copy / name).write_bytes(original)


@moderate
@given(st.data())
def test_a_cloud_that_is_cut_off(whole, copy, data):
    path = next(path for path in copy.rglob('*.pcd') if path.name.startswith('cup'))
    content = path.read_bytes()
    path.write_bytes(content[: data.draw(st.integers(0, len(content) - 1))])
    try:
        complaint = loaded_or_complaint(copy)
        assert isinstance(complaint, str)
        assert complaint.startswith('object cup: ')
        assert str(path) in complaint
    finally:
        path.write_bytes(content)


@moderate
@given(st.text(max_size=60))
def test_any_label_line_gives_labels_or_a_named_error(tmp_path_factory, text):
    path = tmp_path_factory.mktemp('labels') / 'labels.tsv'
    path.write_text(f'scene\tlabel\na_b_0\t3\n{text}\n', encoding='utf-8')
    try:
        labels = read_labels(path)
    except DatasetFormatError as error:
        outcome = str(error)
    else:
        outcome = str(path)
        assert labels['a_b_0'] is Relation.INCLINED
    assert str(path) in outcome


@moderate
@given(st.lists(st.from_regex(r'[a-z]{1,5}_[a-z]{1,5}_[0-9]{1,3}', fullmatch=True), min_size=1))
def test_names_of_a_split_file_are_read_with_their_lines(tmp_path_factory, names):
    path = tmp_path_factory.mktemp('splits') / 'split1_train.txt'
    path.write_text('\n# a remark\n' + '\n'.join(names))
    assert read_scene_names(path) == [(k + 3, name) for k, name in enumerate(names)]


def ascii_cloud(lines, **header):
    entries = {
        'VERSION': '0.7', 'FIELDS': 'x y z', 'SIZE': '4 4 4', 'TYPE': 'F F F', 'COUNT': '1 1 1',
        'WIDTH': '5', 'HEIGHT': '1', 'VIEWPOINT': '0 0 0 1 0 0 0', 'POINTS': '5', 'DATA': 'ascii',
    } | header  # fmt: skip
    text = ''.join(f'{key} {value}\n' for key, value in entries.items() if value is not None)
    return text + ''.join(f'{line}\n' for line in lines)


POINTS = ['0 0 0', '0 0 0.1', '0 0.1 0', '0.1 0 0', '0.1 0.1 0.1']


def test_a_cloud_as_text_is_read(tmp_path):
    path = tmp_path / 'cup.pcd'
    path.write_text(ascii_cloud(POINTS))
    assert load_object_model(path)[1].shape == (5, 3)


@pytest.mark.parametrize(
    ('content', 'complaint'),
    [
        (ascii_cloud(POINTS, POINTS='6'), r'line 9 .*POINTS 6.* width 5 times height 1 is 5'),
        (ascii_cloud(POINTS, WIDTH='-5'), r"line 6 .*'WIDTH -5', expected 1 whole number"),
        (ascii_cloud(POINTS, SIZE='4 4'), r"line 3 .*'SIZE 4 4', expected 3 whole numbers"),
        (ascii_cloud(POINTS, FIELDS='x y w'), r'line 2 .*fields x, y and z are needed'),
        (ascii_cloud(POINTS, DATA='text'), r'line 10 .*must be one of ascii, binary'),
        (ascii_cloud(POINTS, HEIGHT=None), r'no line HEIGHT'),
        (ascii_cloud(POINTS[:2]), r'5 points need at least 29 bytes .* cut off'),
        (ascii_cloud(POINTS[:3], WIDTH='3', POINTS='3'), r'holds 3 points'),
        (ascii_cloud([*POINTS[:4], '0 nan 0']), r'1 of 5 points are not finite'),
        ('no cloud at all', r':1: .*is no line of a pcd header|no line FIELDS'),
    ],
)
def test_malformed_clouds_say_where_and_what(tmp_path, content, complaint):
    path = tmp_path / 'cup.pcd'
    path.write_text(content)
    with pytest.raises(CloudFormatError, match=complaint) as caught:
        load_object_model(path)
    assert str(path) in str(caught.value)


def append(folder: Path, name: str, line: str) -> None:
    with open(folder / name, 'a') as file:
        file.write(line + '\n')


@pytest.mark.parametrize(
    ('name', 'line', 'complaint'),
    [
        ('scenes.txt', 'cup_box_7;0,nan,0;1,0,0,0', r'scenes\.txt:6: .*not finite'),
        ('scenes.txt', 'cup_box_7;0,0,0;0,0,0,0', r'scenes\.txt:6: .*norm 0'),
        ('scenes.txt', 'cup_box_7;0,0,0;1,0,0,0;0,0,0,0', r'scenes\.txt:6: .*norm 0'),
        ('scenes.txt', 'cup_pan_7;0,0,0;1,0,0,0', r'scenes\.txt:6: .* no cloud of pan'),
        ('labels.tsv', 'cup_box_3\t12', r"labels\.tsv:6: label '12' is unknown"),
        ('cross_validation_splits/split1_test.txt', 'cup_box_9', r'test\.txt:2: scene'),
        ('cross_validation_splits/split1_test.txt', 'cup_box_1', r'test\.txt:2: .*also trains'),
        ('cross_validation_splits/split1_train.txt', 'cup_box_1', r'train\.txt:4: .*twice'),
    ],
)
def test_errors_name_the_file_and_the_line(whole, tmp_path, name, line, complaint):
    folder = Path(shutil.copytree(whole, tmp_path / 'data'))
    append(folder, name, line)
    with pytest.raises(DatasetFormatError, match=complaint):
        load_dataset(folder)


def test_an_empty_split_is_an_error(whole, tmp_path):
    folder = Path(shutil.copytree(whole, tmp_path / 'data'))
    (folder / 'cross_validation_splits' / 'split1_test.txt').write_text('\n\n')
    with pytest.raises(DatasetFormatError, match=r'split1_test\.txt: the split is empty'):
        load_dataset(folder)


def test_object_splits_that_share_an_object_are_refused(whole, tmp_path):
    folder = tmp_path / 'data'
    shutil.copytree(whole, folder)
    shutil.copytree(folder / 'cross_validation_splits', folder / 'object_splits')
    with pytest.raises(DatasetFormatError, match=r'split1 tests cup \(scene cup_box_3\) and also'):
        load_dataset(folder)


def test_what_is_written_over_another_dataset_keeps_nothing_of_it(whole, tmp_path):
    folder = tmp_path / 'data'
    shutil.copytree(whole, folder)
    dataset = load_dataset(folder)
    bare = tuple(dataclasses.replace(scene, label=None) for scene in dataset.scenes)
    write_dataset(folder, RelationDataset(dataset.clouds, bare))
    again = load_dataset(folder)
    assert again.splits == ()
    assert set(again.labels) == {-1}
