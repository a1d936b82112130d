"""Writing a dataset folder."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from spatial_relations_ros.core import atomic_write
from spatial_relations_ros.datasets.freiburg.dataset import RelationDataset, Split
from spatial_relations_ros.datasets.freiburg.lines import format_scene_line
from spatial_relations_ros.datasets.freiburg.loading import (
    LABELS_FILE,
    MESHES_FOLDER,
    OBJECT_SPLITS_FOLDER,
    SCENES_FILE,
    SPLITS_FOLDER,
)
from spatial_relations_ros.datasets.object_files import (
    PAPER_CLOUD_ENDING,
    save_cloud,
    save_mesh,
)

SCENES_HEADER = 'name;translation of object 2;q_wxyz of object 2;q_wxyz of object 1 (optional)'
LABELS_HEADER = 'name\tlabel'


def write_dataset(folder: Path | str, dataset: RelationDataset) -> None:
    """Writes a dataset in the paper's folder format; ``load_dataset`` reads it back.

    Clouds go to ``pointclouds/``, meshes to ``meshes/``. Translations are written relative to
    object 1, as the format has it. Scenes, labels and splits that were there before are replaced;
    ``scenes.txt`` is written last, so that what is not written to the end is no dataset.
    """
    folder = Path(folder)
    for name in (SCENES_FILE, LABELS_FILE):
        (folder / name).unlink(missing_ok=True)
    remove_splits(folder)
    for object_id, points in dataset.clouds.items():
        save_cloud(_cloud_path(folder, object_id), points)
    for object_id, mesh in dataset.meshes.items():
        save_mesh(_mesh_path(folder, object_id), mesh)
    labelled = [(s.name, s.label) for s in dataset.scenes if s.label is not None]
    if labelled:
        write_lines(
            folder / LABELS_FILE,
            [LABELS_HEADER] + [f'{name}\t{int(label)}' for name, label in labelled],
        )
    _write_splits(folder / SPLITS_FOLDER, dataset.splits)
    _write_splits(folder / OBJECT_SPLITS_FOLDER, dataset.object_splits)
    write_lines(
        folder / SCENES_FILE,
        [SCENES_HEADER]
        + [
            format_scene_line(scene.name, scene.world_from_base, scene.world_from_relative)
            for scene in dataset.scenes
        ],
    )


def _write_splits(folder: Path, splits: Iterable[Split]) -> None:
    for number, split in enumerate(splits, start=1):
        write_lines(folder / f'split{number}_train.txt', split.train)
        write_lines(folder / f'split{number}_test.txt', split.test)


def remove_models(folder: Path, object_ids: Iterable[str]) -> None:
    """Removes clouds and meshes that :func:`write_dataset` wrote; those of other names stay."""
    for object_id in object_ids:
        _cloud_path(folder, object_id).unlink(missing_ok=True)
        _mesh_path(folder, object_id).unlink(missing_ok=True)


def remove_splits(folder: Path) -> None:
    """Removes the files of all splits."""
    for name in (SPLITS_FOLDER, OBJECT_SPLITS_FOLDER):
        for path in (folder / name).glob('split*_*.txt'):
            path.unlink(missing_ok=True)
        if (folder / name).is_dir() and not any((folder / name).iterdir()):
            (folder / name).rmdir()


def _cloud_path(folder: Path, object_id: str) -> Path:
    return folder / 'pointclouds' / f'{object_id}{PAPER_CLOUD_ENDING}.pcd'


def _mesh_path(folder: Path, object_id: str) -> Path:
    return folder / MESHES_FOLDER / f'{object_id}.ply'


def write_lines(path: Path, lines: Iterable[str]) -> None:
    """Writes a text file, each line ended."""
    with atomic_write(path) as temporary:
        temporary.write_text(''.join(f'{line}\n' for line in lines), encoding='utf-8')
