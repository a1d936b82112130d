"""Summaries as tables: for the terminal and as Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from spatial_relations_ros.core import Relation
from spatial_relations_ros.evaluation.generalization.summary import ALL

COLUMNS = (
    'experiment', 'variant', 'imitated', 'feasible', 'both (95 %)', 'and in balance', 'claimed',
    'right of claimed', 'right of the others', 'first variant there', 's (p90)', 'CPU s', 'steps',
)  # fmt: skip
RELATION_COLUMNS = (
    'relation', 'same class', 'imitated', 'feasible', 'both (95 %)', 'claimed', 'right of claimed',
)  # fmt: skip

Rows = list[tuple[str, ...]]


def overview_rows(summaries: Sequence[dict[str, Any]]) -> Rows:
    """A row for each experiment and variant, in ``COLUMNS``."""
    rows = []
    for summary in summaries:
        total, seconds = summary['relations'][ALL], summary['seconds']
        rows.append(
            (
                summary['experiment'],
                summary['variant'],
                *(of_text(total[name]) for name in ('imitated', 'feasible')),
                interval_text(total['right']),
                *(
                    of_text(total[name])
                    for name in (
                        'right_and_in_balance', 'claimed', 'claimed_right', 'unclaimed_right',
                    )
                ),
                of_text(summary['first_on_same_cases']),
                f'{seconds["median"]:.2f} ({seconds["p90"]:.2f})',
                f'{summary["cpu_seconds"]["median"]:.2f}',
                f'{summary["steps"]["median"]:.0f}',
            )
        )  # fmt: skip
    return rows


def relation_rows(summary: dict[str, Any]) -> Rows:
    """A row for each relation of a summary, in ``RELATION_COLUMNS``."""
    return [
        (
            Relation[name.upper()].description,
            *(of_text(row[key]) for key in ('same_class', 'imitated', 'feasible')),
            interval_text(row['right']),
            *(of_text(row[key]) for key in ('claimed', 'claimed_right')),
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
    """``k of n, p % (low to high)``."""
    low, high = counted['wilson_95']
    return (
        f'{of_text(counted)}, {100.0 * counted["share"]:.1f} % '
        f'({100.0 * low:.0f} to {100.0 * high:.0f})'
    )


def markdown(summaries: Sequence[dict[str, Any]]) -> str:
    """All tables as Markdown: the overview, then each summary by relation with its failures."""
    parts = [_markdown_table(COLUMNS, overview_rows(summaries))]
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
