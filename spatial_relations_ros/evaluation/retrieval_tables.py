"""The results of a comparison as tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from spatial_relations_ros.evaluation.comparison import MEASURES, ComparedMetric

COLUMNS = ('metric', 'splits', '3-of-5 %', '±', '5-of-5 %', '±', 'mean average precision %', '±')
"""± is the standard deviation over splits; over seeds in the rows of several seeds."""

_TITLES = {
    'mees2017_euclidean': 'hand-made features, Euclidean',
    'mees2017_lmnn': 'hand-made features, LMNN',
}

Row = tuple[object, ...]


def table_rows(
    compared: Sequence[ComparedMetric], groups: Sequence[Mapping[str, Any]]
) -> tuple[tuple[str, ...], list[Row]]:
    """Columns and rows: for each protocol every metric, then means over seeds."""
    rows: list[Row] = []
    for protocol in compared[0].reports:
        for item in compared:
            summary = item.reports[protocol].summary()
            spread = [f'{measure}_std' for measure in MEASURES]
            title = _TITLES.get(item.name, item.name)
            rows.append((title, summary['protocol'], *_numbers(summary, spread)))
        for group in groups:
            title = f'mean of {", ".join(group["names"])}'
            spread = [f'{measure}_std_over_seeds' for measure in MEASURES]
            numbers = _numbers(group['protocols'][protocol], spread)
            rows.append((title, f'{protocol}, ± over seeds', *numbers))
    return COLUMNS, rows


def _numbers(summary: Mapping[str, Any], spread: Sequence[str]) -> Row:
    return tuple(
        '' if summary[name] is None else round(100.0 * summary[name], 2)
        for pair in zip(MEASURES, spread, strict=True)
        for name in pair
    )


def markdown_table(compared: Sequence[ComparedMetric], groups: Sequence[Mapping[str, Any]]) -> str:
    """The same as Markdown, with the spread behind each number."""
    _, rows = table_rows(compared, groups)
    lines = [
        '| Metric | Splits | 3-of-5 | 5-of-5 | mean average precision |',
        '|---|---|---|---|---|',
    ]
    for title, splits, *numbers in rows:
        cells = [
            f'{value:.1f} %' + ('' if spread == '' else f' ± {spread:.1f}')
            for value, spread in zip(numbers[::2], numbers[1::2], strict=True)
        ]
        lines.append(f'| {title} | {splits} | {" | ".join(cells)} |')
    return '\n'.join(lines) + '\n'
