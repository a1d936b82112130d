"""Imitation with random pairs of objects that the metric has never seen, judged by geometry.

    python -m spatial_relations_ros.evaluation.random_pairs --per-relation 10

For each relation demonstrations are generated, and two other objects for which the relation is
possible (the generator found a placement, which is thrown away) stand apart on the table. The
base stays as it lay in that placement. What comes out is judged on the full meshes and apart from
the metric: does the pair show the demonstrated relation, and its continuous part within wide
tolerances (:mod:`spatial_relations_ros.evaluation.judging`); and is it without penetration and at
rest with friction on a table tilted by a few degrees?
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.progress import track

from spatial_relations_ros.core import Pose, Relation, Scene, SceneObject, atomic_write
from spatial_relations_ros.datasets.generator import SceneSampler, generate_objects
from spatial_relations_ros.evaluation.intervals import wilson_interval
from spatial_relations_ros.evaluation.judging import compare_relations, judge_scene
from spatial_relations_ros.imitation import ImitationAnswer, ImitationOptions, imitate
from spatial_relations_ros.learning import RelationMetric, load_metric
from spatial_relations_ros.placement.body import Body, Placed
from spatial_relations_ros.placement.contact import MAX_PENETRATION, clearance
from spatial_relations_ros.placement.stability import is_stable, resting_contacts

_NUM_POINTS = 8192
_FAR = 0.25
_BELOW_TABLE = 5e-4


@dataclass(frozen=True)
class Case:
    """Outcome of one imitation.

    Attributes:
        relation: that was demonstrated.
        reference_ids, test_ids: base and relative.
        initial_distance, distance: under the metric, before and after.
        claimed: whether the imitation called itself a success.
        same_class: whether the result shows the demonstrated relation.
        differences: what of the relation differs, in words.
        reason: why the result would not rest where it is; empty when it does.
        duration_sec: of the request.
    """

    relation: str
    reference_ids: tuple[str, str]
    test_ids: tuple[str, str]
    initial_distance: float
    distance: float
    claimed: bool
    same_class: bool
    differences: tuple[str, ...]
    reason: str
    duration_sec: float

    @property
    def is_right(self) -> bool:
        """Whether the relation is imitated, at rest."""
        return self.same_class and not self.differences and not self.reason


def run_cases(
    metric: RelationMetric, *, per_relation: int, num_objects: int, seed: int
) -> list[Case]:
    """Imitates ``per_relation`` demonstrations of each relation; see the module."""
    bodies = [Body.of(model) for model in generate_objects(num_objects, seed=seed)]
    sampler = SceneSampler(bodies)
    cases = []
    for number in track(range(per_relation * len(Relation)), 'imitating'):
        relation = Relation(number % len(Relation))
        rng = np.random.default_rng([seed, number])
        shown = sampler.sample(relation, rng).measured
        possible = sampler.sample(relation, rng).measured
        reference = _scene(shown.base, shown.relative)
        test = _scene(possible.base, _apart(possible.base, possible.relative, rng))
        result = imitate(metric, reference, test, ImitationOptions(table_height=0.0))
        best = result.answers[0]
        agreement = compare_relations(
            judge_scene(reference, 0.0), judge_scene(best.scene(test), 0.0)
        )
        reason = rest_reason(possible.base.body, possible.relative.body, best)
        cases.append(
            Case(
                relation.name, reference.object_ids, test.object_ids, result.initial_distance,
                best.distance, result.success, agreement.same_class, agreement.words, reason,
                result.duration_sec,
            )
        )  # fmt: skip
    return cases


def rest_reason(base: Body, relative: Body, answer: ImitationAnswer) -> str:
    """Why an answer's pair overlaps or does not stay on the table z = 0; empty when it rests."""
    first, second = (
        Placed(body, placement.target.rotation, np.array(placement.target.translation))
        for body, placement in zip((base, relative), answer.placements, strict=True)
    )
    if min(first.world_vertices[:, 2].min(), second.world_vertices[:, 2].min()) < -_BELOW_TABLE:
        return 'below the table'
    if clearance(first, second) < -MAX_PENETRATION:
        return 'penetration'
    if not is_stable(first, second, resting_contacts(first, second)):
        return 'not stable'
    return ''


def _scene(base: Placed, relative: Placed) -> Scene:
    items = []
    for role, placed in (('base', base), ('relative', relative)):
        model = placed.body.model
        items.append(
            SceneObject(
                f'{role}_{model.name}',
                model.points(_NUM_POINTS, np.random.default_rng(0)),
                placed.pose(),
                mesh=model.mesh,
            )
        )
    return Scene(items[0], items[1])


def _apart(base: Placed, relative: Placed, rng: np.random.Generator) -> Placed:
    """The relative upright on the table, away from the base."""
    angle = rng.uniform(0.0, 2.0 * np.pi)
    away = np.array([np.cos(angle), np.sin(angle), 0.0])
    distance = base.body.radius + relative.body.radius + _FAR
    upright = Placed(relative.body, Pose().rotation, base.translation + distance * away)
    return upright.on_table()


def summarize(cases: Sequence[Case]) -> dict[str, Any]:
    """Counts by relation and in all, with intervals, and times."""
    summary: dict[str, Any] = {}
    for name in ('all', *(relation.name for relation in Relation)):
        chosen = [case for case in cases if name in ('all', case.relation)]
        if not chosen:
            continue
        hits = sum(case.is_right for case in chosen)
        summary[name] = {
            'cases': len(chosen),
            'same_class': sum(case.same_class for case in chosen),
            'imitated': sum(case.same_class and not case.differences for case in chosen),
            'imitated_and_at_rest': hits,
            'wilson_95': [round(value, 3) for value in wilson_interval(hits, len(chosen))],
            'claimed': sum(case.claimed for case in chosen),
            'claimed_and_right': sum(case.claimed and case.is_right for case in chosen),
        }
    times = [case.duration_sec for case in cases]
    summary['seconds_median'] = round(float(np.median(times)), 2)
    summary['seconds_p90'] = round(float(np.quantile(times, 0.9)), 2)
    return summary


def main(arguments: Sequence[str] | None = None) -> int:
    """Prints the counts; returns the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').partition('\n')[0])
    parser.add_argument('--weights', type=Path, help='instead of those shipped')
    parser.add_argument('--per-relation', type=int, default=10)
    parser.add_argument('--objects', type=int, default=48)
    parser.add_argument('--seed', type=int, default=101)
    parser.add_argument('--json', type=Path)
    options = parser.parse_args(arguments)
    metric = load_metric(options.weights)
    cases = run_cases(
        metric,
        per_relation=options.per_relation,
        num_objects=options.objects,
        seed=options.seed,
    )
    summary = summarize(cases)
    for name, numbers in summary.items():
        print(f'{name}: {numbers}')
    for case in cases:
        if not case.is_right:
            why = '; '.join(filter(None, (*case.differences, case.reason)))
            print(f'wrong: {case.relation} {case.test_ids} {why}')
    if options.json is not None:
        report = {
            'seed': options.seed,
            'model_hash': metric.model_hash,
            'summary': summary,
            'cases': [asdict(case) for case in cases],
        }
        with atomic_write(options.json) as temporary:
            temporary.write_text(json.dumps(report, indent=2) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
