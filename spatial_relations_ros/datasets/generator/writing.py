"""Generating a whole dataset in the paper's folder format."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from spatial_relations_ros import __version__
from spatial_relations_ros.core import ConfigError, Relation
from spatial_relations_ros.datasets.freiburg import RelationDataset, RelationScene, write_dataset
from spatial_relations_ros.datasets.freiburg.writing import write_lines
from spatial_relations_ros.datasets.generator.body import Body
from spatial_relations_ros.datasets.generator.ground_truth import ground_truth
from spatial_relations_ros.datasets.generator.scenes import GeneratedScene, SceneSampler
from spatial_relations_ros.datasets.generator.splits import (
    group_of,
    num_groups,
    object_splits,
    scene_splits,
)
from spatial_relations_ros.datasets.objects import (
    CONTAINER_FAMILIES,
    OBJECT_FAMILIES,
    ObjectModel,
    sample_object,
)

NUM_SPLITS = 15
MIN_SCENES = 4 * len(Relation)
POINTS_PER_OBJECT = 8192
_SCENES_STREAM, _OBJECTS_STREAM, _CLOUDS_STREAM, _SPLITS_STREAM, _FAMILIES_STREAM = range(5)

OnProgress = Callable[[int, int], None]


def generate_objects(num_objects: int, *, seed: int) -> list[ObjectModel]:
    """Objects spread evenly over the families, named ``<family><number>``.

    The seed shuffles the families, so that small sets hold other ones each time; about a third
    are containers in any set.
    """
    families = _family_order(np.random.default_rng([seed, _FAMILIES_STREAM]))
    models = []
    for idx in range(num_objects):
        family = families[idx % len(families)]
        rng = np.random.default_rng([seed, _OBJECTS_STREAM, idx])
        models.append(sample_object(family, rng, name=f'{family}{idx // len(families)}'))
    return models


def _family_order(rng: np.random.Generator) -> list[str]:
    """All families, shuffled, the containers evenly among the others."""
    others = [family for family in OBJECT_FAMILIES if family not in CONTAINER_FAMILIES]
    placed: list[tuple[float, str]] = []
    for families in (CONTAINER_FAMILIES, others):
        for rank, idx in enumerate(rng.permutation(len(families))):
            placed.append(((rank + 0.5) / len(families), families[idx]))
    return [family for _, family in sorted(placed)]


def generate_dataset(
    folder: Path | str,
    *,
    num_scenes: int,
    num_objects: int,
    seed: int,
    on_progress: OnProgress | None = None,
    num_points: int = POINTS_PER_OBJECT,
) -> None:
    """Writes a dataset of generated scenes.

    The folder holds ``scenes.txt``, ``labels.tsv``, ``cross_validation_splits/`` and the clouds
    as the paper's data does; besides ``dataset.json`` (the
    arguments), ``meshes/<object>.ply``, ``objects.json`` (family and
    dimensions), ``object_splits/`` (no object of a test scene is in a training scene; made from
    48 objects up) and ``ground_truth.jsonl`` (what was measured on each scene; see
    :func:`ground_truth`). All labels are equally frequent. The same arguments give the same
    bytes.

    Args:
        folder: is made; files of the same names are replaced.
        num_scenes: scenes in all, at least 28: splits test a quarter of each relation's.
        num_objects: objects in all, at least 10, spread evenly over the families. From 48
            objects up they are dealt to groups and scenes pair objects of the same group, so
            that splits over objects lose no scene.
        seed: of everything random.
        on_progress: called with ``(scenes done, num_scenes)``.
        num_points: points of each object's cloud, spread evenly over the surface.

    Raises:
        ConfigError: for numbers that are too small.
    """
    if num_scenes < MIN_SCENES or num_objects < 10 or num_points < 4 or seed < 0:
        raise ConfigError(
            f'got {num_scenes} scenes, {num_objects} objects, {num_points} points, seed {seed}; '
            f'at least {MIN_SCENES}, 10, 4 and 0 are needed'
        )
    folder = Path(folder)
    models = generate_objects(num_objects, seed=seed)
    groups = num_groups(num_objects)
    bodies: list[list[Body]] = [[] for _ in range(groups)]
    for idx, model in enumerate(models):
        group = group_of(idx, num_families=len(OBJECT_FAMILIES), groups=groups)
        bodies[group].append(Body.of(model))
    samplers = [SceneSampler(group) for group in bodies]
    scenes, truths = [], []
    for idx in range(num_scenes):
        # Only poses and numbers are kept: a scene's contact points take half a megabyte.
        generated = _scene_of_index(idx, samplers, seed=seed)
        scenes.append(_relation_scene(idx, generated))
        truths.append(ground_truth(scenes[-1].name, generated))
        if on_progress is not None:
            on_progress(idx + 1, num_scenes)
    dataset = _dataset(models, scenes, groups=groups, seed=seed, num_points=num_points)
    write_dataset(folder, dataset)
    described = {
        model.name: {'family': model.family, 'dimensions': dict(model.dimensions)}
        for model in models
    }
    made_with = {
        'num_scenes': num_scenes,
        'num_objects': num_objects,
        'seed': seed,
        'num_points': num_points,
        'version': __version__,
    }
    write_lines(folder / 'dataset.json', [json.dumps(made_with, indent=1)])
    write_lines(folder / 'objects.json', [json.dumps(described, indent=1, sort_keys=True)])
    write_lines(folder / 'ground_truth.jsonl', [json.dumps(truth) for truth in truths])


def _scene_of_index(idx: int, samplers: Sequence[SceneSampler], *, seed: int) -> GeneratedScene:
    relation = Relation(idx % len(Relation))
    group = (idx // len(Relation)) % len(samplers)
    rng = np.random.default_rng([seed, _SCENES_STREAM, idx])
    return samplers[group].sample(relation, rng)


def _dataset(
    models: Sequence[ObjectModel],
    scenes: Sequence[RelationScene],
    *,
    groups: int,
    seed: int,
    num_points: int,
) -> RelationDataset:
    clouds = {
        model.name: model.points(num_points, np.random.default_rng([seed, _CLOUDS_STREAM, idx]))
        for idx, model in enumerate(models)
    }
    names = [scene.name for scene in scenes]
    labels = [Relation(idx % len(Relation)) for idx in range(len(scenes))]
    group_idx = [(idx // len(Relation)) % groups for idx in range(len(scenes))]
    split_rng = np.random.default_rng([seed, _SPLITS_STREAM])
    return RelationDataset(
        clouds,
        tuple(scenes),
        scene_splits(names, labels, num_splits=NUM_SPLITS, rng=split_rng),
        object_splits(names, group_idx, groups=groups, num_splits=NUM_SPLITS),
        {model.name: model.mesh for model in models},
    )


def _relation_scene(idx: int, scene: GeneratedScene) -> RelationScene:
    base, relative = scene.measured.base, scene.measured.relative
    base_id, relative_id = base.body.model.name, relative.body.model.name
    return RelationScene(
        f'{base_id}_{relative_id}_{idx}',
        base_id,
        relative_id,
        base.pose(),
        relative.pose(),
        scene.relation,
    )
