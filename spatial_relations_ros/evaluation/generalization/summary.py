"""Counts over outcomes, with intervals; failures by cause."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from spatial_relations_ros.core import Relation
from spatial_relations_ros.evaluation.generalization.outcome import Outcome
from spatial_relations_ros.evaluation.intervals import wilson_interval

ALL = 'all'


def summarize(outcomes: Sequence[Outcome]) -> list[dict[str, Any]]:
    """A summary for each experiment and variant, in the order in which they first occur.

    Returns:
        Dictionaries with ``experiment``, ``variant``, ``relations`` (``all`` and each relation's
        name to the counts of :func:`counts`), ``failures`` (cause to count, the most frequent
        first), ``steps``, ``seconds`` and ``cpu_seconds`` (``median``, ``p90``), and
        ``first_on_same_cases``: how often the experiment's first variant is right on the cases
        of this one, which may be fewer.
    """
    groups = _grouped(outcomes)
    return [
        {
            'experiment': experiment,
            'variant': variant,
            'relations': {
                name: counts(chosen) for name, chosen in _by_relation(members) if chosen
            },
            'failures': failures(members),
            'steps': _spread([outcome.attempt.num_steps for outcome in members], digits=1),
            'seconds': _spread([outcome.attempt.seconds for outcome in members], digits=3),
            'cpu_seconds': _spread([outcome.attempt.cpu_seconds for outcome in members], digits=3),
            'first_on_same_cases': _on_same_cases(groups, experiment, members),
        }
        for (experiment, variant), members in groups.items()
    ]


def counts(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """How many of some cases came out how; each ``{hits, of, share, wilson_95}``.

    ``same_class``, ``imitated`` (class and continuous part), ``feasible``, ``right`` (both),
    ``right_and_in_balance``; ``claimed`` (called a success by the variant itself),
    ``claimed_right`` (right, of those) and ``unclaimed_right`` (right, of the others). The last
    three are None for a variant that claims nothing.
    """
    claimed = [outcome for outcome in outcomes if outcome.attempt.claimed]
    unclaimed = [outcome for outcome in outcomes if outcome.attempt.claimed is False]
    can_claim = bool(claimed or unclaimed)
    return {
        'cases': len(outcomes),
        'same_class': share([outcome.is_same_class for outcome in outcomes]),
        'imitated': share([outcome.is_imitated for outcome in outcomes]),
        'feasible': share([outcome.is_feasible for outcome in outcomes]),
        'right': share([outcome.is_right for outcome in outcomes]),
        'right_and_in_balance': share(
            [
                outcome.is_right
                and outcome.feasibility is not None
                and outcome.feasibility.in_balance
                for outcome in outcomes
            ]
        ),
        'claimed': share([bool(outcome.attempt.claimed) for outcome in outcomes])
        if can_claim
        else None,
        'claimed_right': share([outcome.is_right for outcome in claimed]) if can_claim else None,
        'unclaimed_right': share([outcome.is_right for outcome in unclaimed])
        if can_claim
        else None,
    }


def share(hits: Sequence[bool]) -> dict[str, Any]:
    """Hits of a number of trials with the 95 % Wilson interval; no share of none."""
    if not hits:
        return {'hits': 0, 'of': 0, 'share': None, 'wilson_95': None}
    low, high = wilson_interval(sum(hits), len(hits))
    return {
        'hits': sum(hits),
        'of': len(hits),
        'share': round(sum(hits) / len(hits), 4),
        'wilson_95': [round(low, 4), round(high, 4)],
    }


def failures(outcomes: Sequence[Outcome]) -> dict[str, int]:
    """Causes of failures and how often, the most frequent first, then by name."""
    causes = Counter(outcome.cause for outcome in outcomes if outcome.cause)
    return dict(sorted(causes.items(), key=lambda item: (-item[1], item[0])))


def _on_same_cases(
    groups: Mapping[tuple[str, str], Sequence[Outcome]],
    experiment: str,
    members: Sequence[Outcome],
) -> dict[str, Any]:
    first = next(rows for (name, _), rows in groups.items() if name == experiment)
    numbers = {outcome.number for outcome in members}
    return share([outcome.is_right for outcome in first if outcome.number in numbers])


def _grouped(outcomes: Sequence[Outcome]) -> dict[tuple[str, str], list[Outcome]]:
    groups: dict[tuple[str, str], list[Outcome]] = {}
    for outcome in outcomes:
        groups.setdefault((outcome.experiment, outcome.variant), []).append(outcome)
    # Experiments one after the other, variants within in the order given.
    order = list(dict.fromkeys(experiment for experiment, _ in groups))
    return dict(sorted(groups.items(), key=lambda item: order.index(item[0][0])))


def _by_relation(outcomes: Sequence[Outcome]) -> Iterator[tuple[str, list[Outcome]]]:
    yield ALL, list(outcomes)
    for relation in Relation:
        yield (
            relation.name.lower(),
            [outcome for outcome in outcomes if outcome.relation is relation],
        )


def _spread(values: Sequence[float], *, digits: int) -> dict[str, float]:
    return {
        'median': round(float(np.median(values)), digits),
        'p90': round(float(np.quantile(values, 0.9)), digits),
    }
