"""What a training leaves out to be measured on, and how the card names data."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from spatial_relations_ros.core import DatasetFormatError
from spatial_relations_ros.datasets.freiburg import RelationDataset, load_dataset
from spatial_relations_ros.datasets.freiburg.lines import read_json
from spatial_relations_ros.datasets.freiburg.loading import SCENES_FILE
from spatial_relations_ros.evaluation.labelled_scenes import LabelledScenes
from spatial_relations_ros.evaluation.splits_report import check_splits


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Scenes that are not trained with.

    Attributes:
        trained: names of the scenes to train with.
        dataset: with the splits to measure retrieval on.
        tested: scenes for the calibration.
        described: of these, for the card.
    """

    trained: frozenset[str]
    dataset: RelationDataset
    tested: LabelledScenes
    described: dict[str, Any]

    @staticmethod
    def of(dataset: RelationDataset, data_dir: Path, folder: Path | None) -> HeldOut:
        """Another dataset, or a split of this one; trouble is told here, before any training.

        Args:
            dataset: to train with.
            data_dir: its folder.
            folder: of another dataset of other objects; None takes the first split over objects,
                else over scenes.

        Raises:
            DatasetFormatError: for data that retrieval cannot be measured on, and for the same
                scenes.
        """
        if folder is not None:
            other = load_dataset(folder)
            check_splits(other)
            if _scenes_sha256(folder) == _scenes_sha256(data_dir):
                raise DatasetFormatError(
                    f'{folder} holds the scenes of {data_dir}, which are trained with; name '
                    'scenes of other objects, or nothing to hold out a split'
                )
            names = frozenset(entry.name for entry in dataset.scenes)
            described = {'data': describe_data(folder, other)}
            return HeldOut(names, other, LabelledScenes.of(other), described)
        if dataset.object_splits:
            split, name = dataset.object_splits[0], 'object'
            one = dataclasses.replace(dataset, splits=(), object_splits=(split,))
        elif dataset.splits:
            split, name = dataset.splits[0], 'scene'
            one = dataclasses.replace(dataset, splits=(split,), object_splits=())
        else:
            raise DatasetFormatError(
                'the dataset has no split to hold scenes out; name another dataset for that'
            )
        check_splits(one)
        tested = LabelledScenes.of(dataset, frozenset(split.test))
        return HeldOut(frozenset(split.train), one, tested, {'split': f'{name} {split.name}'})


def describe_data(
    folder: Path, dataset: RelationDataset, *, names: Collection[str] | None = None
) -> dict[str, Any]:
    """What identifies a dataset: counts, the hash of its scene file, and how it was generated.

    Args:
        folder: of the dataset.
        dataset: read from there.
        names: of the labelled scenes to count, and their objects; None counts all scenes.

    Raises:
        DatasetFormatError: when ``dataset.json`` is there and cannot be read.
    """
    made_with = folder / 'dataset.json'
    generated = {'generated': read_json(made_with)} if made_with.is_file() else {}
    scenes = dataset.scenes if names is None else LabelledScenes.of(dataset, names).entries
    return {
        'num_objects': len(
            {one for scene in scenes for one in (scene.base_id, scene.relative_id)}
        ),
        'num_scenes': len(scenes),
        'scenes_sha256': _scenes_sha256(folder),
        **generated,
    }


def _scenes_sha256(folder: Path) -> str:
    return hashlib.sha256((folder / SCENES_FILE).read_bytes()).hexdigest()
