"""Whether cases that failed can be done at all: many placements, judged and simulated.

    python -m spatial_relations_ros.evaluation.generalization.possible held_out REPORT.json

For each case of a report of ``relations generalize`` that is not right, placements are drawn by
the rules of imitation, brought to rest, and judged; what imitates the relation is let go in
MuJoCo, until one stays. The metric is not asked. That none is found does not prove that there is
none.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.progress import track

from spatial_relations_ros.core import Pose, atomic_write
from spatial_relations_ros.datasets.freiburg import load_dataset
from spatial_relations_ros.evaluation.generalization.attempt import Attempt
from spatial_relations_ros.evaluation.generalization.cases import BOTH, Case
from spatial_relations_ros.evaluation.generalization.experiments import Plan, make_experiments
from spatial_relations_ros.evaluation.generalization.outcome import judge_attempt
from spatial_relations_ros.imitation.arrangement import demonstrated_arrangement, is_alike
from spatial_relations_ros.imitation.orientations import resting_orientations, standing_bases
from spatial_relations_ros.imitation.proposals import Proposal, Proposer
from spatial_relations_ros.imitation.shape import shape_of
from spatial_relations_ros.imitation.tabletop import Tabletop
from spatial_relations_ros.placement.arrangement import Arrangement
from spatial_relations_ros.placement.settling import Manner, settle
from spatial_relations_ros.placement.tipping import tipped

NUM_DRAWN = 600
MAX_SIMULATED = 12

_VARIED_SHARE = 0.5
# Placements between two looks for footholds, of which every other one is taken.
_A_LOOK = 50


@dataclass(frozen=True)
class Possibility:
    """What was found of a case.

    Attributes:
        drawn: placements that came to rest.
        imitated: of those that were judged, how many imitate the relation.
        simulated: of those, how many were let go.
        right: whether one stayed.
    """

    drawn: int
    imitated: int
    simulated: int
    right: bool


def look_for_any(case: Case, *, num_drawn: int = NUM_DRAWN, seed: int = 0) -> Possibility:
    """Draws placements of a case until one imitates the relation and stays.

    Placements whose arrangement is clearly not the demonstration's are not judged.

    Raises:
        ConfigError: where MuJoCo is not installed.
    """
    wanted = demonstrated_arrangement(case.reference)
    drawn = imitated = simulated = 0
    for poses, arrangement in _placements(case, num_drawn, wanted, np.random.default_rng(seed)):
        drawn += 1
        if wanted is not None and not is_alike(arrangement, wanted):
            continue
        attempt = _attempt(poses)
        if not judge_attempt(case, 'any', attempt, simulate=False).is_imitated:
            continue
        imitated += 1
        if simulated < MAX_SIMULATED:
            simulated += 1
            if judge_attempt(case, 'any', attempt, simulate=True).is_right:
                return Possibility(drawn, imitated, simulated, True)
    return Possibility(drawn, imitated, simulated, False)


def _attempt(poses: tuple[Pose, Pose]) -> Attempt:
    return Attempt(poses, None, None, 0.0, 0.0, 0, 0.0, 0.0)


def _placements(
    case: Case, count: int, wanted: Arrangement | None, rng: np.random.Generator
) -> Iterator[tuple[tuple[Pose, Pose], Arrangement]]:
    """Pairs at rest with their arrangements: of all kinds, and near such as are alike."""
    shapes = shape_of(case.test.base), shape_of(case.test.relative)
    tabletop = Tabletop.of(shapes, case.test.base.world_from_object, 0.0)
    base, relative = (
        tabletop.placed(role, item.world_from_object)
        for role, item in enumerate(case.test.objects)
    )
    bases = standing_bases(base, upright=False) if case.movable == BOTH else [base]
    orientations = resting_orientations(relative.body, relative.rotation)
    proposer = Proposer(bases, relative.body, orientations, rng)
    parents: list[Proposal] = []
    footholds: Iterator[Proposal] = iter(())
    for number in range(count):
        if number % _A_LOOK == 0:
            footholds = proposer.on_footholds(_A_LOOK)
        if parents and rng.random() < _VARIED_SHARE:
            proposal = proposer.vary(parents[rng.integers(len(parents))])
        elif number % 2 == 0:
            proposal = next(footholds, None)
        else:
            proposal = proposer.draw(number // 2 % len(proposer.cells))
        rested = None if proposal is None else _at_rest(proposal, tabletop)
        if rested is None:
            continue
        arrangement = Arrangement.of(rested.base, rested.relative)
        if wanted is not None and is_alike(arrangement, wanted):
            parents.append(rested)
        base_pose = case.test.base.world_from_object
        if 'base' in case.movable:
            base_pose = tabletop.pose(0, rested.base)
        yield (base_pose, tabletop.pose(1, rested.relative)), arrangement


def _at_rest(proposal: Proposal, tabletop: Tabletop) -> Proposal | None:
    """With all points of contact, and tilted onto three of them where it was let down."""
    base, relative = (
        replace(placed, body=solid.body)
        for placed, solid in zip((proposal.base, proposal.relative), tabletop.solids, strict=True)
    )
    placed = settle(proposal.manner, relative, base)
    if placed is not None and proposal.manner is Manner.DROPPED:
        placed = tipped(placed, base)
    return None if placed is None else replace(proposal, base=base, relative=placed)


def main(arguments: list[str] | None = None) -> int:
    """Looks for placements of what failed and says for how many there is one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('folder', type=Path, help='of the demonstrations, as in the report')
    parser.add_argument('report', type=Path, help='--json of relations generalize')
    parser.add_argument('--unknown', type=Path, help='folder of unknown objects')
    parser.add_argument('--random', type=int, default=0, help='random pairs in the report')
    parser.add_argument('--random-objects', type=int, default=194)
    parser.add_argument('--drawn', type=int, default=NUM_DRAWN, help='placements a case')
    parser.add_argument('--json', type=Path)
    options = parser.parse_args(arguments)
    report = json.loads(options.report.read_text())
    plan = Plan(
        any(entry['name'] == 'known' for entry in report['experiments']), options.unknown,
        options.random, options.random_objects, None, report['seed'], report['simulated'],
    )  # fmt: skip
    cases = {
        (case.experiment, case.number): case
        for experiment in make_experiments(load_dataset(options.folder), plan)
        for case in experiment.cases
    }
    failed = [entry for entry in report['cases'] if entry['cause']]
    rows: list[dict[str, Any]] = []
    for entry in track(failed, 'looking'):
        found = look_for_any(cases[entry['experiment'], entry['case']], num_drawn=options.drawn)
        rows.append({**{key: entry[key] for key in _KEPT}, **vars(found)})
    for experiment in dict.fromkeys(row['experiment'] for row in rows):
        members = [row for row in rows if row['experiment'] == experiment]
        print(
            f'{experiment}: of {len(members)} that failed, {sum(row["right"] for row in members)} '
            f'are possible, {sum(not row["imitated"] for row in members)} were never imitated'
        )
    if options.json is not None:
        with atomic_write(options.json) as temporary:
            temporary.write_text(json.dumps(rows, indent=2) + '\n')
    return 0


_KEPT = ('experiment', 'case', 'relation', 'reference', 'test', 'cause')

if __name__ == '__main__':
    sys.exit(main())
