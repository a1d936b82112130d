"""Dataset folders: round trip, tolerance, errors."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import open3d as o3d
import pytest

from spatial_relations_ros.core import DatasetFormatError, Pose, Relation
from spatial_relations_ros.datasets.freiburg import (
    RelationDataset,
    RelationScene,
    Split,
    load_dataset,
    write_dataset,
)
from spatial_relations_ros.datasets.object_files import save_cloud, save_mesh
from spatial_relations_ros.datasets.objects import sample_object


def make_dataset() -> RelationDataset:
    rng = np.random.default_rng(0)
    models = [sample_object(f, rng, name=f'{f}0') for f in ('box', 'cup')]
    models += [sample_object(f, rng, name=f'{f}1') for f in ('box', 'cup')]
    scenes = []
    for number in range(4):
        quats = rng.normal(size=(2, 4))
        quats /= np.linalg.norm(quats, axis=1, keepdims=True)
        base = Pose(np.zeros(3), quats[0] if number else np.array([1.0, 0, 0, 0]))
        relative = Pose(rng.normal(size=3) * 0.1, quats[1])
        label = Relation(number) if number < 3 else None
        scenes.append(RelationScene(f'box0_cup0_{number}', 'box0', 'cup0', base, relative, label))
    names = tuple(scene.name for scene in scenes)
    apart = dataclasses.replace(scenes[0], name='box1_cup1_0', base_id='box1', relative_id='cup1')
    return RelationDataset(
        {model.name: model.points(200, rng) for model in models},
        (*scenes, apart),
        (Split('split1', names[:3], names[3:]), Split('split2', names[1:], names[:1])),
        (Split('split1', names[:2], (apart.name,)),),
        {model.name: model.mesh for model in models},
    )


@pytest.fixture
def folder(tmp_path) -> Path:
    write_dataset(tmp_path / 'data', make_dataset())
    return tmp_path / 'data'


def test_round_trip(folder):
    written, read = make_dataset(), load_dataset(folder)
    assert read.clouds.keys() == written.clouds.keys()
    for name, points in written.clouds.items():
        np.testing.assert_array_equal(read.clouds[name], points)
        np.testing.assert_array_equal(read.meshes[name].vertices, written.meshes[name].vertices)
        np.testing.assert_array_equal(read.meshes[name].triangles, written.meshes[name].triangles)
    assert [s.name for s in read.scenes] == [s.name for s in written.scenes]
    for mine, theirs in zip(read.scenes, written.scenes, strict=True):
        assert (mine.base_id, mine.relative_id) == (theirs.base_id, theirs.relative_id)
        assert mine.label is theirs.label
        assert mine.world_from_base.is_close(theirs.world_from_base)
        assert mine.world_from_relative.is_close(theirs.world_from_relative)
    assert read.splits == written.splits
    assert read.object_splits == written.object_splits
    assert read.labels.tolist() == [0, 1, 2, -1, 0]


def test_every_line_has_the_four_fields_of_the_authors_reader(folder):
    lines = (folder / 'scenes.txt').read_text().splitlines()
    assert all(line.count(';') == 3 for line in lines)


def test_scene_of_a_name_has_clouds_and_meshes(folder):
    dataset = load_dataset(folder)
    scene = dataset.scene('box0_cup0_1')
    assert scene.object_ids == ('box0', 'cup0')
    assert scene.base.mesh is not None
    expected = dataset.scenes[1].world_from_relative.apply(dataset.clouds['cup0'])
    np.testing.assert_allclose(scene.relative.world_points, expected, atol=1e-6)
    with pytest.raises(DatasetFormatError, match=r"no scene 'nothing'.*box0_cup0_0"):
        dataset.scene('nothing')


def test_clouds_may_lie_anywhere_as_ascii_or_mesh(folder):
    dataset = make_dataset()
    for path in sorted(folder.rglob('*0*.p[cl][dy]')):
        path.unlink()
    deep = folder / 'objects' / 'box' / 'clouds'
    deep.mkdir(parents=True)
    cloud = o3d.geometry.PointCloud(
        o3d.utility.Vector3dVector(dataset.clouds['box0'].astype(np.float64))
    )
    o3d.io.write_point_cloud(deep / 'box0.pcd', cloud, write_ascii=True)
    save_mesh(folder / 'objects' / 'cup0.ply', dataset.meshes['cup0'])
    read = load_dataset(folder)
    np.testing.assert_allclose(read.clouds['box0'], dataset.clouds['box0'], atol=1e-6)
    assert len(read.clouds['cup0']) > 1000
    assert set(read.meshes) == {'cup0', 'box1', 'cup1'}


def test_object_names_may_hold_underscores(folder):
    save_cloud(folder / 'milk_carton.pcd', np.random.default_rng(0).random((10, 3)))
    with open(folder / 'scenes.txt', 'a') as file:
        file.write('milk_carton_cup0_9;0,0,0.1;1,0,0,0;\ncup0_milk_carton_10;0,0,0.1;1,0,0,0\n')
    scenes = load_dataset(folder).scenes
    assert (scenes[-2].base_id, scenes[-2].relative_id) == ('milk_carton', 'cup0')
    assert (scenes[-1].base_id, scenes[-1].relative_id) == ('cup0', 'milk_carton')


def test_labels_of_unknown_scenes_are_warned_of(folder):
    with open(folder / 'labels.tsv', 'a') as file:
        file.write('box0_cup0_77\t1\n')
    with pytest.warns(UserWarning, match='box0_cup0_77'):
        load_dataset(folder)


def break_cloud_missing(folder: Path) -> str:
    next(folder.rglob('cup0*.pcd')).unlink()
    (folder / 'meshes' / 'cup0.ply').unlink()
    return r'scenes\.txt:2: scene box0_cup0_0 has no cloud of cup0'


def break_small_cloud(folder: Path) -> str:
    save_cloud(next(folder.rglob('cup0*.pcd')), np.eye(3))
    return 'object cup0: .* holds 3 points'


def break_nan_cloud(folder: Path) -> str:
    points = np.random.default_rng(0).random((10, 3))
    points[4, 1] = np.nan
    save_cloud(next(folder.rglob('cup0*.pcd')), points)
    return 'object cup0: .*1 of 10 points are not finite'


def break_empty_cloud(folder: Path) -> str:
    next(folder.rglob('cup0*.pcd')).write_bytes(b'')
    return 'object cup0: .* is empty'


def break_scenes_missing(folder: Path) -> str:
    (folder / 'scenes.txt').unlink()
    return r'holds no scenes\.txt; there is .*labels\.tsv'


def break_label(folder: Path) -> str:
    with open(folder / 'labels.tsv', 'a') as file:
        file.write('box0_cup0_3\t9\n')
    return r"labels\.tsv:6: label '9' is unknown"


def break_split_empty(folder: Path) -> str:
    (folder / 'cross_validation_splits' / 'split2_test.txt').write_text('')
    return r'split2_test\.txt: the split is empty'


def break_split_name(folder: Path) -> str:
    (folder / 'cross_validation_splits' / 'split2_test.txt').write_text('box0_cup0_0\nx_y_1\n')
    return r"split2_test\.txt:2: scene 'x_y_1' is not in scenes\.txt"


def break_split_missing(folder: Path) -> str:
    (folder / 'cross_validation_splits' / 'split2_test.txt').unlink()
    return r'split2_test\.txt does not exist'


def break_split_half_missing(folder: Path) -> str:
    (folder / 'cross_validation_splits' / 'split2_train.txt').unlink()
    return r'split2_train\.txt does not exist'


def break_first_label(folder: Path) -> str:
    lines = (folder / 'labels.tsv').read_text().splitlines()[1:]
    lines[0] = lines[0].split()[0] + '\tontop'
    (folder / 'labels.tsv').write_text('\n'.join(lines))
    return r"labels\.tsv:1: label 'ontop' is unknown"


def break_far_away(folder: Path) -> str:
    with open(folder / 'scenes.txt', 'a') as file:
        file.write('box0_cup0_9;0,1e300,0.1;1,0,0,0;\n')
    return r"scenes\.txt:7: translation '0,1e300,0.1' is farther than 10000"


def break_same_object(folder: Path) -> str:
    with open(folder / 'scenes.txt', 'a') as file:
        file.write('cup0_cup0_9;0,0,0.1;1,0,0,0;\n')
    return r'scenes\.txt:7: cup0_cup0_9 names the same object twice'


@pytest.mark.parametrize(
    'damage',
    [
        break_cloud_missing,
        break_small_cloud,
        break_nan_cloud,
        break_empty_cloud,
        break_scenes_missing,
        break_label,
        break_split_empty,
        break_split_name,
        break_split_missing,
        break_split_half_missing,
        break_first_label,
        break_far_away,
        break_same_object,
    ],
)
def test_damaged_folders_say_what_is_wrong(folder, damage):
    complaint = damage(folder)
    with pytest.raises(DatasetFormatError, match=complaint):
        load_dataset(folder)


def test_a_missing_folder(tmp_path):
    with pytest.raises(DatasetFormatError, match='is not a folder'):
        load_dataset(tmp_path / 'absent')
