"""Drawing the scenes of a dataset, in one process or in several."""

from __future__ import annotations

import multiprocessing
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np

from spatial_relations_ros.core import Relation
from spatial_relations_ros.datasets.freiburg import RelationScene
from spatial_relations_ros.datasets.generator.checks import Measured
from spatial_relations_ros.datasets.generator.ground_truth import ground_truth
from spatial_relations_ros.datasets.generator.scenes import GeneratedScene, SceneSampler
from spatial_relations_ros.datasets.generator.splits import group_of, num_groups
from spatial_relations_ros.datasets.objects import (
    CONTAINER_FAMILIES,
    OBJECT_FAMILIES,
    sample_object,
)
from spatial_relations_ros.placement.body import Body
from spatial_relations_ros.placement.model import ObjectModel
from spatial_relations_ros.placement.physics import settle

_SCENES_STREAM, _OBJECTS_STREAM = 0, 1
_FAMILIES_STREAM = 4
_CHUNK = len(Relation)


@dataclass(frozen=True, eq=False)
class DrawnScene:
    """A scene's poses, its line of ground truth and its refused candidates by reason."""

    scene: RelationScene
    truth: dict[str, object]
    rejected: Counter[str]


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


def group_of_scene(scene_idx: int, groups: int) -> int:
    """Group of objects that a scene is made of; each has all relations in turn."""
    return (scene_idx // len(Relation)) % groups


class SceneDrawer:
    """Draws the scenes of a dataset by their number; each has a random stream of its own."""

    def __init__(self, models: Sequence[ObjectModel], *, seed: int, physics: bool) -> None:
        """Prepares the models' contact queries."""
        groups = num_groups(len(models))
        bodies: list[list[Body]] = [[] for _ in range(groups)]
        for idx, model in enumerate(models):
            group = group_of(idx, num_families=len(OBJECT_FAMILIES), groups=groups)
            bodies[group].append(Body.of(model))
        check = _settling_reason if physics else None
        self._samplers = [SceneSampler(group, check=check) for group in bodies]
        self._seed = seed

    def draw(self, idx: int) -> DrawnScene:
        """The scene of a number."""
        sampler = self._samplers[group_of_scene(idx, len(self._samplers))]
        rng = np.random.default_rng([self._seed, _SCENES_STREAM, idx])
        generated = sampler.sample(Relation(idx % len(Relation)), rng)
        # Only poses and numbers are kept: a scene's contact points take half a megabyte.
        scene = _relation_scene(idx, generated)
        return DrawnScene(scene, ground_truth(scene.name, generated), generated.rejected)


def draw_scenes(
    models: Sequence[ObjectModel],
    *,
    num_scenes: int,
    seed: int,
    num_jobs: int = 1,
    physics: bool = False,
) -> Iterator[DrawnScene]:
    """Scenes 0 to ``num_scenes`` in order; the same for any number of processes.

    Args:
        models: from :func:`generate_objects` with the same seed.
        num_scenes: how many.
        seed: of everything random.
        num_jobs: processes; with 1 the caller's own does the work.
        physics: refuse what does not stay where it is in a simulation.
    """
    if num_jobs == 1:
        drawer = SceneDrawer(models, seed=seed, physics=physics)
        yield from map(drawer.draw, range(num_scenes))
        return
    with ProcessPoolExecutor(
        num_jobs,
        # A fork would copy the locks of the thread pools of Open3D and of OpenMP.
        mp_context=multiprocessing.get_context('spawn'),
        initializer=_start_worker,
        initargs=(len(models), seed, physics),
    ) as pool:
        yield from pool.map(_draw_in_worker, range(num_scenes), chunksize=_CHUNK)


def _settling_reason(measured: Measured) -> str:
    """Why a scene is refused: what moves when it is let go; empty when all stays."""
    motions = settle((measured.base, measured.relative))
    return '' if all(motion.stayed for motion in motions) else 'moves in simulation'


_worker_drawer: SceneDrawer | None = None


def _start_worker(num_objects: int, seed: int, physics: bool) -> None:
    """Makes a worker process its own drawer: contact queries cannot be sent to it."""
    global _worker_drawer
    models = generate_objects(num_objects, seed=seed)
    _worker_drawer = SceneDrawer(models, seed=seed, physics=physics)


def _draw_in_worker(idx: int) -> DrawnScene:
    assert _worker_drawer is not None
    return _worker_drawer.draw(idx)


def _family_order(rng: np.random.Generator) -> list[str]:
    """All families, shuffled, the containers evenly among the others."""
    others = [family for family in OBJECT_FAMILIES if family not in CONTAINER_FAMILIES]
    placed: list[tuple[float, str]] = []
    for families in (CONTAINER_FAMILIES, others):
        for rank, idx in enumerate(rng.permutation(len(families))):
            placed.append(((rank + 0.5) / len(families), families[idx]))
    return [family for _, family in sorted(placed)]


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
