"""Whether the judge asks for what other objects can do.

    python -m spatial_relations_ros.evaluation.generalization.reachability --pairs 20

For each relation pairs of objects are drawn, and each pair is placed several times by the
generator's own rules. Every pair is then compared with a placement of every other pair: a judge
that asks for nothing that shapes forbid agrees with at least one placement of nearly every pair,
one that asks for something does not agree with all of them, and neither ever agrees with scenes
of another relation.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.progress import track

from spatial_relations_ros.core import Relation, SpatialRelationsError, atomic_write
from spatial_relations_ros.datasets.generator import SceneSampler, generate_objects
from spatial_relations_ros.evaluation.generalization.placed_scenes import scene_of_placed
from spatial_relations_ros.evaluation.intervals import wilson_interval
from spatial_relations_ros.evaluation.judging import (
    Judgement,
    Tolerances,
    compare_relations,
    judge_scene,
)
from spatial_relations_ros.placement.body import Body


@dataclass(frozen=True, eq=False)
class PlacedPair:
    """A pair of objects that the generator placed in one relation several times.

    Attributes:
        relation: that they were placed in.
        object_ids: base and relative.
        judgements: of each placement, at least one.
    """

    relation: Relation
    object_ids: tuple[str, str]
    judgements: tuple[Judgement, ...]


def place_pairs(
    *, num_pairs: int, num_placements: int, num_objects: int, seed: int
) -> list[PlacedPair]:
    """Draws ``num_pairs`` pairs for each relation and places each ``num_placements`` times."""
    bodies = [Body.of(model) for model in generate_objects(num_objects, seed=seed)]
    sampler = SceneSampler(bodies)
    pairs = []
    for number in track(range(num_pairs * len(Relation)), 'placing'):
        relation = Relation(number % len(Relation))
        rng = np.random.default_rng([seed, number])
        pairs.append(_place_pair(sampler, relation, num_placements, rng))
    return pairs


def _place_pair(
    sampler: SceneSampler, relation: Relation, num_placements: int, rng: np.random.Generator
) -> PlacedPair:
    first = sampler.sample(relation, rng).measured
    base, relative = first.base.body, first.relative.body
    own = SceneSampler(
        [base, relative], check=lambda drawn: '' if drawn.base.body is base else 'roles swapped'
    )
    drawn = [first]
    while len(drawn) < num_placements:
        try:
            drawn.append(own.sample(relation, rng).measured)
        except SpatialRelationsError:  # a pair that fits only just; what was found counts
            break
    scenes = [scene_of_placed(measured.base, measured.relative) for measured in drawn]
    return PlacedPair(
        relation, scenes[0].object_ids, tuple(judge_scene(scene, 0.0) for scene in scenes)
    )


def measure_reachability(
    pairs: Sequence[PlacedPair], tolerances: Tolerances | None = None
) -> dict[str, dict[str, Any]]:
    """Compares every pair with the first placement of every other one, by relation.

    Returns:
        For each relation ``reachable`` of ``pairs`` (at least one placement agrees) with its 95 %
        interval, ``agreeing_placements`` (a share), ``other_relations_agreeing`` of
        ``other_relations`` (scenes of other relations that agree), and what ``differs`` in those
        of the same relation, by quantity.
    """
    tolerances = tolerances or Tolerances()
    return {
        relation.name.lower(): _reachability(pairs, relation, tolerances)
        for relation in Relation
        if any(pair.relation is relation for pair in pairs)
    }


def _reachability(
    pairs: Sequence[PlacedPair], relation: Relation, tolerances: Tolerances
) -> dict[str, Any]:
    reached, agreeing, others = [], [], []
    differs: Counter[str] = Counter()
    for reference in pairs:
        shown = reference.judgements[0]
        # What the judge gets wrong is counted by `judge_accuracy`, not here.
        if reference.relation is not relation or shown.relation is not relation:
            continue
        for pair in pairs:
            if pair is reference:
                continue
            compared = [compare_relations(shown, item, tolerances) for item in pair.judgements]
            hits = [item.same_relation for item in compared]
            if pair.relation is not relation:
                others += hits
                continue
            agreeing += hits
            reached.append(any(hits))
            differs.update(item.quantity for each in compared for item in each.differences)
            differs['class'] += sum(not item.same_class for item in compared)
    return {
        'pairs': len(reached),
        'reachable': sum(reached),
        'wilson_95': _interval(sum(reached), len(reached)),
        'placements': len(agreeing),
        'agreeing_placements': round(sum(agreeing) / max(len(agreeing), 1), 4),
        'other_relations': len(others),
        'other_relations_agreeing': sum(others),
        'differs': {name: count for name, count in differs.most_common() if count},
    }


def _interval(hits: int, total: int) -> list[float] | None:
    return [round(bound, 3) for bound in wilson_interval(hits, total)] if total else None


def main(arguments: Sequence[str] | None = None) -> int:
    """Prints the shares; returns the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').partition('\n')[0])
    parser.add_argument('--pairs', type=int, default=20, help='of each relation')
    parser.add_argument('--placements', type=int, default=8, help='of each pair')
    parser.add_argument('--objects', type=int, default=194)
    parser.add_argument('--seed', type=int, default=303)
    parser.add_argument('--json', type=Path)
    options = parser.parse_args(arguments)
    pairs = place_pairs(
        num_pairs=options.pairs,
        num_placements=options.placements,
        num_objects=options.objects,
        seed=options.seed,
    )
    table = measure_reachability(pairs)
    for name, row in table.items():
        print(
            f'{name}: {row["reachable"]} of {row["pairs"]} reachable, '
            f'{100.0 * row["agreeing_placements"]:.1f} % of the placements agree, '
            f'{row["other_relations_agreeing"]} of {row["other_relations"]} of other relations; '
            f'differs: {row["differs"]}'
        )
    if options.json is not None:
        report = {**vars(options), 'json': None, 'tolerances': asdict(Tolerances()), **table}
        with atomic_write(options.json) as temporary:
            temporary.write_text(json.dumps(report, indent=2) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
