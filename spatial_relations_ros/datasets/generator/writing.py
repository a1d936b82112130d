"""Generating a whole dataset in the paper's folder format."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from spatial_relations_ros import __version__
from spatial_relations_ros.core import ConfigError, Relation
from spatial_relations_ros.datasets.freiburg import RelationDataset, RelationScene, write_dataset
from spatial_relations_ros.datasets.freiburg.lines import read_json
from spatial_relations_ros.datasets.freiburg.loading import SCENES_FILE
from spatial_relations_ros.datasets.freiburg.writing import (
    remove_models,
    write_lines,
)
from spatial_relations_ros.datasets.generator.drawing import (
    DrawnScene,
    draw_scenes,
    generate_objects,
    group_of_scene,
)
from spatial_relations_ros.datasets.generator.splits import (
    num_groups,
    object_splits,
    scene_splits,
)
from spatial_relations_ros.datasets.ground_truth import GROUND_TRUTH_FILE
from spatial_relations_ros.placement.model import ObjectModel

MADE_WITH_FILE, OBJECTS_FILE = 'dataset.json', 'objects.json'
NUM_SPLITS = 15
MIN_SCENES = 4 * len(Relation)
POINTS_PER_OBJECT = 8192
_LEAST = (MIN_SCENES, 10, 4, 0, 1)
_CLOUDS_STREAM, _SPLITS_STREAM = 2, 3

OnProgress = Callable[[int, int], None]


def generate_dataset(
    folder: Path | str,
    *,
    num_scenes: int,
    num_objects: int,
    seed: int,
    on_progress: OnProgress | None = None,
    num_points: int = POINTS_PER_OBJECT,
    num_jobs: int = 1,
    physics: bool = False,
) -> None:
    """Writes a dataset of generated scenes.

    The folder holds ``scenes.txt``, ``labels.tsv``, ``cross_validation_splits/`` and the clouds
    as the paper's data does; besides ``dataset.json`` (the arguments, and how many candidates
    were refused for what), ``meshes/<object>.ply``, ``objects.json`` (family and dimensions),
    ``object_splits/`` (no object of a test scene is in a training scene; made from 48 objects
    up) and ``ground_truth.jsonl`` (what was measured on each scene; see :func:`ground_truth`).
    All labels are equally frequent. The same arguments give the same bytes.

    Args:
        folder: is made; a dataset that was generated there before is replaced.
        num_scenes: scenes in all, at least 28: splits test a quarter of each relation's.
        num_objects: objects in all, at least 10, spread evenly over the families. From 48
            objects up they are dealt to groups and scenes pair objects of the same group, so
            that splits over objects lose no scene.
        seed: of everything random.
        on_progress: called with ``(scenes done, num_scenes)``.
        num_points: points of each object's cloud, spread evenly over the surface.
        num_jobs: processes; their number does not change what is written.
        physics: refuse scenes that do not stay as they are in a simulation.

    Raises:
        ConfigError: for numbers that are too small, a folder with other scenes, or ``physics``
            without MuJoCo.
    """
    got = (num_scenes, num_objects, num_points, seed, num_jobs)
    if any(value < least for value, least in zip(got, _LEAST, strict=True)):
        raise ConfigError(
            '{} scenes, {} objects, {} points, seed {}, {} jobs: '.format(*got)
            + 'at least {}, {}, {}, {} and {} are needed'.format(*_LEAST)
        )
    folder = Path(folder)
    before = _objects_before(folder)
    models = generate_objects(num_objects, seed=seed)
    drawn = []
    source = draw_scenes(
        models, num_scenes=num_scenes, seed=seed, num_jobs=num_jobs, physics=physics
    )
    for scene in source:
        drawn.append(scene)
        if on_progress is not None:
            on_progress(len(drawn), num_scenes)
    scenes = [entry.scene for entry in drawn]
    described = {
        model.name: {'family': model.family, 'dimensions': dict(model.dimensions)}
        for model in models
    }
    made_with = {
        'num_scenes': num_scenes,
        'num_objects': num_objects,
        'seed': seed,
        'num_points': num_points,
        'physics': physics,
        'version': __version__,
        'rejected': _rejected(drawn),
    }
    # These two first: they say, if the rest is not written to the end, that all may be replaced.
    write_lines(folder / MADE_WITH_FILE, [json.dumps(made_with, indent=1)])
    everything = {**dict.fromkeys(before, None), **described}
    write_lines(folder / OBJECTS_FILE, [json.dumps(everything, indent=1, sort_keys=True)])
    # Without scenes, what is half replaced is no dataset; with the old ones it would be a mixture.
    (folder / SCENES_FILE).unlink(missing_ok=True)
    remove_models(folder, before - set(described))
    write_lines(folder / GROUND_TRUTH_FILE, [json.dumps(entry.truth) for entry in drawn])
    write_dataset(folder, _dataset(models, scenes, seed=seed, num_points=num_points))
    write_lines(folder / OBJECTS_FILE, [json.dumps(described, indent=1, sort_keys=True)])


def _objects_before(folder: Path) -> set[str]:
    """The objects of the generated dataset that a folder holds; none where there is none.

    Raises:
        ConfigError: when it holds scenes that were not generated.
        DatasetFormatError: when its list of objects cannot be read.
    """
    if not (folder / MADE_WITH_FILE).is_file():
        if (folder / SCENES_FILE).exists():
            raise ConfigError(
                f'{folder} holds scenes that were not generated; choose another folder'
            )
        return set()
    return set(read_json(folder / OBJECTS_FILE)) if (folder / OBJECTS_FILE).is_file() else set()


def _rejected(drawn: Sequence[DrawnScene]) -> dict[str, dict[str, int]]:
    """Refused candidates of each relation, by reason, the most frequent first."""
    totals = {relation: Counter[str]() for relation in Relation}
    for entry in drawn:
        if entry.scene.label is not None:
            totals[entry.scene.label].update(entry.rejected)
    return {
        relation.name.lower(): dict(sorted(total.items(), key=lambda item: (-item[1], item[0])))
        for relation, total in totals.items()
    }


def _dataset(
    models: Sequence[ObjectModel],
    scenes: Sequence[RelationScene],
    *,
    seed: int,
    num_points: int,
) -> RelationDataset:
    clouds = {
        model.name: model.points(num_points, np.random.default_rng([seed, _CLOUDS_STREAM, idx]))
        for idx, model in enumerate(models)
    }
    names = [scene.name for scene in scenes]
    labels = [Relation(idx % len(Relation)) for idx in range(len(scenes))]
    groups = num_groups(len(models))
    group_idx = [group_of_scene(idx, groups) for idx in range(len(scenes))]
    split_rng = np.random.default_rng([seed, _SPLITS_STREAM])
    return RelationDataset(
        clouds,
        tuple(scenes),
        scene_splits(names, labels, num_splits=NUM_SPLITS, rng=split_rng),
        object_splits(names, group_idx, groups=groups, num_splits=NUM_SPLITS),
        {model.name: model.mesh for model in models},
    )
