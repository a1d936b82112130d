"""The third experiment: random pairs of generated objects, placements known to be possible."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from spatial_relations_ros.core import Pose, Relation
from spatial_relations_ros.datasets.generator import Measured, SceneSampler, generate_objects
from spatial_relations_ros.evaluation.generalization.cases import Case, Experiment
from spatial_relations_ros.evaluation.generalization.feasibility import MOVED, remember_parts
from spatial_relations_ros.evaluation.generalization.placed_scenes import scene_of_placed
from spatial_relations_ros.placement.body import Body, Placed
from spatial_relations_ros.placement.physics import settle

RANDOM = 'random'

_STREAM = 13
_FAR = 0.25


def random_experiment(
    *,
    num_cases: int,
    num_objects: int,
    seed: int,
    simulate: bool = False,
    on_progress: Callable[[int, int], None] | None = None,
) -> Experiment:
    """Random pairs of the whole object library.

    Relations take turns. The demonstration and the test pair are drawn by the generator, so that
    the relation is possible for both. Of the test pair's placement only the base stays as it lay;
    the relative stands upright apart from it.

    Args:
        num_cases: how many.
        num_objects: that pairs are drawn from; at least 97 for one of each family.
        seed: of objects and scenes.
        simulate: take only scenes that stay as they are for a second in MuJoCo, so that for each
            case there is a placement that is feasible.
        on_progress: called with (cases drawn, cases in all).

    Raises:
        SpatialRelationsError: when too few objects cannot show a relation.
        ConfigError: where MuJoCo is asked for and not installed.
    """
    bodies = [Body.of(model) for model in generate_objects(num_objects, seed=seed)]
    sampler = SceneSampler(bodies, check=_moving_reason if simulate else None)
    cases = []
    for number in range(num_cases):
        relation = Relation(number % len(Relation))
        rng = np.random.default_rng([seed, _STREAM, number])
        shown = sampler.sample(relation, rng).measured
        possible = sampler.sample(relation, rng).measured
        reference = scene_of_placed(shown.base, shown.relative)
        test = scene_of_placed(possible.base, apart(possible.base, possible.relative, rng))
        cases.append(
            Case(
                number, RANDOM, relation, reference, test, '_'.join(reference.object_ids),
                '_'.join(test.object_ids), ('relative',),
                (possible.base.body.model.density, possible.relative.body.model.density),
            )
        )  # fmt: skip
        if on_progress is not None:
            on_progress(number + 1, num_cases)
    for body in bodies:
        if 'convex_parts' in body.__dict__:  # those that were simulated
            remember_parts(body.model.mesh, body.convex_parts)
    return Experiment(
        RANDOM,
        tuple(cases),
        f'random pairs of {num_objects} generated objects; the base stays as it lies, the '
        'relative starts apart',
    )


def _moving_reason(measured: Measured) -> str:
    """Why a drawn scene is refused: it does not stay as it is."""
    motions = settle((measured.base, measured.relative))
    return '' if all(motion.stayed for motion in motions) else MOVED


def apart(base: Placed, relative: Placed, rng: np.random.Generator) -> Placed:
    """The relative upright on the table z = 0, at least 25 cm away from the base."""
    angle = rng.uniform(0.0, 2.0 * np.pi)
    away = np.array([np.cos(angle), np.sin(angle), 0.0])
    distance = base.body.radius + relative.body.radius + _FAR
    upright = Placed(relative.body, Pose().rotation, base.translation + distance * away)
    return upright.on_table()
