"""What a training leaves out to be measured on, and how the card names data."""

from __future__ import annotations

import dataclasses
import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from spatial_relations_ros.core import DatasetFormatError
from spatial_relations_ros.datasets.freiburg import RelationDataset, load_dataset
from spatial_relations_ros.datasets.freiburg.lines import read_json
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
    def of(dataset: RelationDataset, folder: Path | None) -> HeldOut:
        """Another dataset, or a split of this one; trouble is told here, before any training.

        Args:
            dataset: to train with.
            folder: of another dataset of other objects; None takes the first split over objects,
                else over scenes.

        Raises:
            DatasetFormatError: for data that retrieval cannot be measured on.
        """
        if folder is not None:
            other = load_dataset(folder)
            check_splits(other)
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
    folder: Path, dataset: RelationDataset, *, num_scenes: int | None = None
) -> dict[str, Any]:
    """What identifies a dataset: counts, the hash of its scene file, and how it was generated.

    Raises:
        DatasetFormatError: when ``dataset.json`` is there and cannot be read.
    """
    scenes_file, made_with = folder / 'scenes.txt', folder / 'dataset.json'
    generated = {'generated': read_json(made_with)} if made_with.is_file() else {}
    return {
        'num_objects': len(dataset.clouds),
        'num_scenes': len(dataset.scenes) if num_scenes is None else num_scenes,
        'scenes_sha256': hashlib.sha256(scenes_file.read_bytes()).hexdigest(),
        **generated,
    }
