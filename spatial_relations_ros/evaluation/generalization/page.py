"""Cases for a report page: what was shown, what came out, and how it was judged."""

from __future__ import annotations

from collections.abc import Sequence

from spatial_relations_ros.evaluation.generalization.cases import Case
from spatial_relations_ros.evaluation.generalization.outcome import Outcome
from spatial_relations_ros.visualization import ShownAnswer, ShownCheck, ShownImitation

MAX_CASES = 40


def shown_outcomes(
    cases: Sequence[Case], outcomes: Sequence[tuple[int, Outcome]]
) -> list[ShownImitation]:
    """What a page shows of outcomes, failures first; of many every so many-th.

    Args:
        cases: of all experiments.
        outcomes: each with the place of its case.
    """
    ordered = sorted(outcomes, key=lambda item: (item[1].is_right, item[1].cause))
    stride = max(1, -(-len(ordered) // MAX_CASES))
    return [_shown(cases[idx], outcome) for idx, outcome in ordered[::stride]]


def _shown(case: Case, outcome: Outcome) -> ShownImitation:
    attempt = outcome.attempt
    start = case.test.base.world_from_object, case.test.relative.world_from_object
    word = 'right' if outcome.is_right else outcome.cause
    facts = (
        ('experiment', f'{outcome.experiment} {outcome.number}'),
        ('variant', outcome.variant),
        ('demonstration', outcome.reference_name),
        ('test scene', outcome.test_name),
        ('distance before', f'{attempt.initial_distance:.2f}'),
        ('distance after', f'{attempt.distance:.2f}'),
        ('time', f'{attempt.seconds:.2f} s'),
        ('optimiser steps', str(attempt.num_steps)),
    )
    answer = ShownAnswer(
        attempt.poses or start, attempt.distance, outcome.is_feasible, _checks(outcome)
    )
    return ShownImitation(
        f'{outcome.experiment} {outcome.number}, {outcome.variant}, '
        f'{outcome.relation.description}: {word}',
        case.reference, case.test, (answer,), success=outcome.is_right,
        message=f'{outcome.relation.description}: {word}', facts=facts, table_height=0.0,
    )  # fmt: skip


def _checks(outcome: Outcome) -> tuple[ShownCheck, ...]:
    found = 'none' if outcome.found is None else outcome.found.description
    checks = [
        ShownCheck('relation found', found, outcome.is_same_class),
        ShownCheck('imitated', 'yes' if outcome.is_imitated else 'no', outcome.is_imitated),
    ]
    checks += [ShownCheck('differs', words, False) for words in outcome.differences]
    feasibility = outcome.feasibility
    if feasibility is not None:
        checks.append(
            ShownCheck('possible', 'yes' if feasibility.feasible else 'no', feasibility.feasible)
        )
        checks += [ShownCheck('not possible', reason, False) for reason in feasibility.reasons]
        checks.append(ShownCheck('deepest overlap', f'{1000.0 * feasibility.penetration:.1f} mm'))
        balance = 'yes' if feasibility.in_balance else 'no'
        checks.append(ShownCheck('in balance', balance, feasibility.in_balance))
    if outcome.attempt.claimed is not None:
        claimed = 'good' if outcome.attempt.claimed else 'not good'
        checks.append(ShownCheck('claimed of itself', claimed))
    return tuple(checks)
