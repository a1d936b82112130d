"""Summaries as tables: for the terminal and as Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from spatial_relations_ros.core import Relation
from spatial_relations_ros.evaluation.generalization.summary import ALL

RESULT_COLUMNS = (
    'experiment', 'variant', 'imitated', 'feasible', 'both', '95 %', 's (p90)', 'CPU s', 'steps',
)  # fmt: skip
CLAIM_COLUMNS = (
    'experiment', 'variant', 'both and in balance', 'claimed', 'right of claimed',
    'right of the others', 'first variant there',
)  # fmt: skip
RELATION_COLUMNS = ('relation', 'same class', 'imitated', 'feasible', 'both', '95 %', 'claimed')

Rows = list[tuple[str, ...]]


def result_rows(summaries: Sequence[dict[str, Any]]) -> Rows:
    """A row for each experiment and variant, in ``RESULT_COLUMNS``."""
    return [
        (
            *_names(summary),
            *(of_text(_total(summary)[name]) for name in ('imitated', 'feasible', 'right')),
            interval_text(_total(summary)['right']),
            f'{summary["seconds"]["median"]:.2f} ({summary["seconds"]["p90"]:.2f})',
            f'{summary["cpu_seconds"]["median"]:.2f}',
            f'{summary["steps"]["median"]:.0f}',
        )
        for summary in summaries
    ]


def claim_rows(summaries: Sequence[dict[str, Any]]) -> Rows:
    """A row for each experiment and variant, in ``CLAIM_COLUMNS``."""
    counted = ('right_and_in_balance', 'claimed', 'claimed_right', 'unclaimed_right')
    return [
        (
            *_names(summary),
            *(of_text(_total(summary)[name]) for name in counted),
            of_text(summary['first_on_same_cases']),
        )
        for summary in summaries
    ]


def _names(summary: dict[str, Any]) -> tuple[str, str]:
    return summary['experiment'], summary['variant']


def _total(summary: dict[str, Any]) -> dict[str, Any]:
    total: dict[str, Any] = summary['relations'][ALL]
    return total


def relation_rows(summary: dict[str, Any]) -> Rows:
    """A row for each relation of a summary, in ``RELATION_COLUMNS``."""
    return [
        (
            Relation[name.upper()].description,
            *(of_text(row[key]) for key in ('same_class', 'imitated', 'feasible', 'right')),
            interval_text(row['right']),
            of_text(row['claimed']),
        )
        for name, row in summary['relations'].items()
        if name != ALL
    ]


def failure_text(summary: dict[str, Any]) -> str:
    """Causes with their counts in a line."""
    return ', '.join(f'{count} {cause}' for cause, count in summary['failures'].items()) or 'none'


def of_text(counted: dict[str, Any] | None) -> str:
    """``k of n``; a dash where there is nothing to count."""
    return '-' if counted is None or not counted['of'] else f'{counted["hits"]} of {counted["of"]}'


def interval_text(counted: dict[str, Any]) -> str:
    """``p % (low to high)`` with the 95 % interval."""
    low, high = counted['wilson_95']
    return f'{100.0 * counted["share"]:.1f} % ({100.0 * low:.0f} to {100.0 * high:.0f})'


def markdown(summaries: Sequence[dict[str, Any]]) -> str:
    """All tables as Markdown: results, claims, then each summary by relation with failures."""
    parts = [
        _markdown_table(RESULT_COLUMNS, result_rows(summaries)),
        _markdown_table(CLAIM_COLUMNS, claim_rows(summaries)),
    ]
    for summary in summaries:
        parts.append(
            f'{summary["experiment"]}, {summary["variant"]}:\n\n'
            f'{_markdown_table(RELATION_COLUMNS, relation_rows(summary))}\n'
            f'Failures: {failure_text(summary)}.\n'
        )
    return '\n'.join(parts)


def _markdown_table(columns: Sequence[str], rows: Rows) -> str:
    lines = [columns, ['---'] * len(columns), *rows]
    return ''.join(f'| {" | ".join(line)} |\n' for line in lines)
