"""Reading a dataset folder."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path

from spatial_relations_ros.core import CloudFormatError, DatasetFormatError, Relation
from spatial_relations_ros.datasets.freiburg.dataset import (
    RelationDataset,
    RelationScene,
    Split,
)
from spatial_relations_ros.datasets.freiburg.lines import (
    SceneLine,
    read_labels,
    read_scene_lines,
    read_scene_names,
)
from spatial_relations_ros.datasets.object_files import (
    MODEL_SUFFIXES,
    PAPER_CLOUD_ENDING,
    load_object_model,
)

MESHES_FOLDER = 'meshes'
SCENES_FILE = 'scenes.txt'
LABELS_FILE = 'labels.tsv'
SPLITS_FOLDER = 'cross_validation_splits'
OBJECT_SPLITS_FOLDER = 'object_splits'


def load_dataset(folder: Path | str) -> RelationDataset:
    """Reads a folder in the paper's format, the authors' data or generated.

    Needs ``scenes.txt`` and, anywhere below the folder, a cloud or mesh of each object
    (``<object>_uniform_leafzise_0.001.pcd``, ``<object>.pcd``, or ply, obj, stl, off).
    ``labels.tsv`` and the split folders are read where they are.

    Raises:
        DatasetFormatError: with file and line, for anything missing or malformed.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise DatasetFormatError(f'{folder} is not a folder')
    scenes_path = folder / SCENES_FILE
    if not scenes_path.is_file():
        there = ', '.join(sorted(path.name for path in folder.iterdir())[:12]) or 'nothing'
        raise DatasetFormatError(f'{folder} holds no {SCENES_FILE}; there is {there}')
    lines = read_scene_lines(scenes_path)
    labels_path = folder / LABELS_FILE
    labels = read_labels(labels_path) if labels_path.is_file() else {}
    cloud_files, mesh_files = _model_files(folder)
    known = set(cloud_files) | set(mesh_files)
    scenes = []
    for line in lines:
        base_id, relative_id = _object_ids(line, known, scenes_path)
        scenes.append(
            RelationScene(
                line.name,
                base_id,
                relative_id,
                line.world_from_base,
                line.world_from_relative,
                labels.get(line.name),
            )
        )
    _warn_of_unused_labels(labels, scenes, labels_path)
    used = {name for scene in scenes for name in (scene.base_id, scene.relative_id)}
    return _with_models(folder, scenes, sorted(used), cloud_files, mesh_files)


def _warn_of_unused_labels(
    labels: Mapping[str, Relation], scenes: list[RelationScene], path: Path
) -> None:
    unused = sorted(set(labels) - {scene.name for scene in scenes})
    if unused:
        warnings.warn(
            f'{path}: {len(unused)} labels, such as that of {unused[0]}, belong to no scene of '
            f'{SCENES_FILE}',
            stacklevel=3,
        )


def _with_models(
    folder: Path,
    scenes: list[RelationScene],
    object_ids: list[str],
    cloud_files: Mapping[str, Path],
    mesh_files: Mapping[str, Path],
) -> RelationDataset:
    clouds, meshes = {}, {}
    for object_id in object_ids:
        try:
            # Meshes elsewhere may be in another frame than the cloud: used only without one.
            mesh_file = mesh_files.get(object_id)
            in_place = mesh_file is not None and mesh_file.parent.name == MESHES_FOLDER
            if mesh_file is not None and (in_place or object_id not in cloud_files):
                mesh, clouds[object_id] = load_object_model(mesh_file)
                if mesh is not None:
                    meshes[object_id] = mesh
            if object_id in cloud_files:
                _, clouds[object_id] = load_object_model(cloud_files[object_id])
        except CloudFormatError as error:
            raise DatasetFormatError(f'object {object_id}: {error}') from error
    names = {scene.name for scene in scenes}
    object_splits = _read_splits(folder / OBJECT_SPLITS_FOLDER, names)
    _check_objects_apart(folder / OBJECT_SPLITS_FOLDER, object_splits, scenes)
    return RelationDataset(
        clouds,
        tuple(scenes),
        _read_splits(folder / SPLITS_FOLDER, names),
        object_splits,
        meshes,
    )


def _check_objects_apart(
    folder: Path, splits: Iterable[Split], scenes: Iterable[RelationScene]
) -> None:
    """No object of a test scene may be in a training scene."""
    objects_of = {scene.name: (scene.base_id, scene.relative_id) for scene in scenes}
    for split in splits:
        trains = {one: name for name in split.train for one in objects_of[name]}
        for name in split.test:
            for one in objects_of[name]:
                if one in trains:
                    raise DatasetFormatError(
                        f'{folder}: {split.name} tests {one} (scene {name}) and also trains with '
                        f'it (scene {trains[one]}); splits over scenes belong to {SPLITS_FOLDER}/'
                    )


def _model_files(folder: Path) -> tuple[dict[str, Path], dict[str, Path]]:
    """Clouds and meshes below a folder, by object name."""
    clouds: dict[str, Path] = {}
    meshes: dict[str, Path] = {}
    for path in sorted(folder.rglob('*')):
        if path.suffix.lower() not in MODEL_SUFFIXES or not path.is_file():
            continue
        name = path.stem.removesuffix(PAPER_CLOUD_ENDING)
        files = clouds if path.suffix.lower() == '.pcd' else meshes
        # The cloud made for the paper comes before other clouds of the object.
        if name not in files or path.stem.endswith(PAPER_CLOUD_ENDING):
            files[name] = path
    return clouds, meshes


def _object_ids(line: SceneLine, known: set[str], path: Path) -> tuple[str, str]:
    """The two objects of a scene name; names may hold underscores themselves."""
    words = line.name.split('_')[:-1]
    pairs = [('_'.join(words[:cut]), '_'.join(words[cut:])) for cut in range(1, len(words))]
    found = [pair for pair in pairs if set(pair) <= known]
    where = f'{path}:{line.line_number}'
    if not found:
        missing = sorted({name for pair in pairs for name in pair} - known)
        raise DatasetFormatError(
            f'{where}: scene {line.name} has no cloud of {" or ".join(missing)} below '
            f'{path.parent}; expected {missing[0]}{PAPER_CLOUD_ENDING}.pcd, {missing[0]}.pcd or a '
            f'mesh ({len(known)} objects found)'
        )
    if len(found) > 1:
        raise DatasetFormatError(f'{where}: {line.name} can be read as any of {found}')
    if found[0][0] == found[0][1]:
        raise DatasetFormatError(f'{where}: {line.name} names the same object twice')
    return found[0]


def _read_splits(folder: Path, names: set[str]) -> tuple[Split, ...]:
    if not folder.is_dir():
        return ()
    # By either part, so that one without the other is missed.
    numbers = sorted(
        {
            int(match.group(1))
            for path in folder.iterdir()
            if (match := re.fullmatch(r'split(\d+)_(train|test)\.txt', path.name))
        }
    )
    if not numbers:
        raise DatasetFormatError(f'{folder} holds no split<k>_train.txt')
    return tuple(_read_split(folder, number, names) for number in numbers)


def _read_split(folder: Path, number: int, names: set[str]) -> Split:
    train_path = folder / f'split{number}_train.txt'
    test_path = folder / f'split{number}_test.txt'
    train = _split_part(train_path, names)
    test = _split_part(test_path, names)
    for name, line in test.items():
        if name in train:
            raise DatasetFormatError(
                f'{test_path}:{line}: scene {name} is tested and also trains '
                f'({train_path.name}:{train[name]})'
            )
    return Split(f'split{number}', tuple(train), tuple(test))


def _split_part(path: Path, names: Iterable[str]) -> dict[str, int]:
    """Scene names of a part of a split, in the file's order, with their lines."""
    lines: dict[str, int] = {}
    for number, name in read_scene_names(path):
        if name not in names:
            raise DatasetFormatError(f'{path}:{number}: scene {name!r} is not in {SCENES_FILE}')
        if name in lines:
            raise DatasetFormatError(
                f'{path}:{number}: scene {name} is listed twice, first on line {lines[name]}'
            )
        lines[name] = number
    return lines
