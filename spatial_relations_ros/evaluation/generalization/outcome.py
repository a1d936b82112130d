"""Judging an attempt: the relation, its continuous part, and whether it is possible."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Any
from weakref import WeakKeyDictionary

from spatial_relations_ros.core import Relation, Scene
from spatial_relations_ros.evaluation.entries import ROLES, pose_entry
from spatial_relations_ros.evaluation.generalization.attempt import Attempt
from spatial_relations_ros.evaluation.generalization.cases import Case
from spatial_relations_ros.evaluation.generalization.feasibility import (
    BELOW_TABLE,
    PENETRATION,
    Feasibility,
    check_feasibility,
)
from spatial_relations_ros.evaluation.judging import Judgement, compare_relations, judge_scene

REFUSED = 'refused'


@dataclass(frozen=True, eq=False)
class Outcome:
    """An attempt and what geometry and simulation say of it.

    Attributes:
        experiment, number: of the case.
        variant: that made the attempt.
        relation: that was demonstrated.
        reference_name, test_name: of the scenes.
        test_ids: base and relative.
        attempt: what was answered.
        found: the relation that the result shows; None for none of the seven.
        differences: what of the relation differs, in words; empty when it is imitated.
        mismatch: the first difference as a short cause; empty when it is imitated.
        feasibility: of the result; None when there is none.
    """

    experiment: str
    number: int
    variant: str
    relation: Relation
    reference_name: str
    test_name: str
    test_ids: tuple[str, str]
    attempt: Attempt
    found: Relation | None
    differences: tuple[str, ...]
    mismatch: str
    feasibility: Feasibility | None

    @property
    def is_same_class(self) -> bool:
        """Whether the result shows the demonstrated relation, whatever its continuous part."""
        return self.found is self.relation

    @property
    def is_imitated(self) -> bool:
        """Whether class and continuous part agree."""
        return not self.mismatch

    @property
    def is_feasible(self) -> bool:
        """Whether the result is physically possible."""
        return self.feasibility is not None and self.feasibility.feasible

    @property
    def is_right(self) -> bool:
        """Imitated and feasible."""
        return self.is_imitated and self.is_feasible

    @property
    def cause(self) -> str:
        """Why it is not right, in a few words; empty when it is."""
        reasons = self.feasibility.reasons if self.feasibility is not None else ()
        return self.mismatch or (reasons[0] if reasons else '')

    def entry(self) -> dict[str, Any]:
        """As it stands in JSON; only ``seconds`` and ``cpu_seconds`` change from run to run."""
        attempt, feasibility = self.attempt, self.feasibility
        entry: dict[str, Any] = {
            'experiment': self.experiment,
            'case': self.number,
            'variant': self.variant,
            'relation': self.relation.name.lower(),
            'reference': self.reference_name,
            'test': self.test_name,
            'found': None if self.found is None else self.found.name.lower(),
            'imitated': self.is_imitated,
            'differences': list(self.differences),
            'feasible': self.is_feasible,
            'infeasible_for': list(feasibility.reasons) if feasibility is not None else [],
            'cause': self.cause,
            'claimed': attempt.claimed,
            'confidence': attempt.confidence,
            'distance': attempt.distance,
            'difference': None if attempt.difference is None else round(attempt.difference, 4),
            'initial_distance': attempt.initial_distance,
            'steps': attempt.num_steps,
            'message': attempt.message,
            'seconds': round(attempt.seconds, 4),
            'cpu_seconds': round(attempt.cpu_seconds, 4),
        }
        if feasibility is not None:
            entry |= _feasibility_entry(feasibility)
        if attempt.poses is not None:
            entry['poses'] = {
                role: pose_entry(pose) for role, pose in zip(ROLES, attempt.poses, strict=True)
            }
        return entry


def _feasibility_entry(feasibility: Feasibility) -> dict[str, Any]:
    motions = feasibility.motions
    return {
        'penetration': round(feasibility.penetration, 5),
        'below_table': round(feasibility.below_table, 5),
        'in_balance': feasibility.in_balance,
        'moved': None
        if motions is None
        else {
            role: {'shift': round(motion.shift, 4), 'turn_rad': round(motion.turn_rad, 4)}
            for role, motion in zip(ROLES, motions, strict=True)
        },
    }


def judge_attempt(case: Case, variant: str, attempt: Attempt, *, simulate: bool) -> Outcome:
    """Judges an attempt on the full meshes; the metric is not asked.

    Raises:
        ConfigError: where MuJoCo is asked for and not installed.
    """
    found: Relation | None = None
    differences: tuple[str, ...] = (attempt.message,)
    mismatch, feasibility = REFUSED, None
    if attempt.poses is not None:
        scene = attempt.scene(case)
        judgement = judge_scene(scene, 0.0)
        agreement = compare_relations(_judged_reference(case), judgement)
        found, differences = judgement.relation, agreement.words
        feasibility = check_feasibility(
            scene, judgement.measures, case.densities, simulate=simulate
        )
        mismatch = ''
        if not agreement.same_class:
            mismatch = _class_cause(judgement, feasibility)
        elif agreement.differences:
            mismatch = agreement.differences[0].quantity
    return Outcome(
        case.experiment, case.number, variant, case.relation, case.reference_name, case.test_name,
        case.test.object_ids, attempt, found, differences, mismatch, feasibility,
    )  # fmt: skip


def _class_cause(judgement: Judgement, feasibility: Feasibility) -> str:
    if judgement.relation is not None:
        return f'{judgement.relation.description} instead'
    overlaps = [name for name in feasibility.reasons if name in (PENETRATION, BELOW_TABLE)]
    if overlaps:
        return overlaps[0]
    return 'no relation: ' + re.split(r'\s*\d', judgement.reason, maxsplit=1)[0].rstrip(', ')


_references: WeakKeyDictionary[Scene, Judgement] = WeakKeyDictionary()


def _judged_reference(case: Case) -> Judgement:
    """The reference as judged, with the relation that is known of it."""
    if case.reference not in _references:
        _references[case.reference] = judge_scene(case.reference, 0.0)
    return replace(_references[case.reference], relation=case.relation)
