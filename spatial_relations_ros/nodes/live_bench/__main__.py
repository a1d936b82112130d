"""The command: python -m spatial_relations_ros.nodes.live_bench, or relations bench live."""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from spatial_relations_ros.core import SpatialRelationsError, atomic_write
from spatial_relations_ros.core.interrupts import interrupt_on_signals
from spatial_relations_ros.evaluation.live_rates import (
    COLUMNS,
    LiveRun,
    markdown_table,
    run_entry,
    table_rows,
)
from spatial_relations_ros.evaluation.live_stream import FORMATS, stream_format
from spatial_relations_ros.nodes.live_bench.bench import LiveOptions, measure
from spatial_relations_ros.ros.domains import free_domain_id
from spatial_relations_ros.ros.processes import local_graph

DEFAULT_STREAMS = ('sd', 'qhd')


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='live_bench',
        description='Sends clouds of four tracked objects to a perception node, by processes of '
        'their own, and tells what is received, how fast scenes come out and what it costs.',
    )
    parser.add_argument('--stream', action='append', choices=list(FORMATS), help='repeat for more')
    parser.add_argument('--duration', type=float, default=20.0, help='seconds of each stream')
    parser.add_argument('--minutes', type=float, help='the same in minutes, for a soak')
    parser.add_argument('--rate', type=float, default=30.0, help='clouds a second')
    parser.add_argument('--reliable', action='store_true', help='clouds by reliable delivery')
    parser.add_argument('--without-models', action='store_true')
    parser.add_argument('--all-pairs', action='store_true', help='all 12 scenes of each cloud')
    parser.add_argument('--json', type=Path, help='file for the results; - for standard output')
    parser.add_argument('--markdown', type=Path, help='file for the table')
    parser.add_argument('--provenance', default='{}', help='JSON to put into the results')
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Measures; exit code 0 when nothing was lost, 1 when clouds or scenes were, 2 otherwise."""
    args = _parser().parse_args(arguments)
    # Ended from outside it still ends its nodes.
    interrupt_on_signals()
    options = LiveOptions(
        duration_sec=args.duration if args.minutes is None else 60.0 * args.minutes,
        rate=args.rate,
        is_reliable=args.reliable,
        with_models=not args.without_models,
        all_pairs=args.all_pairs,
    )
    is_piped = str(args.json) == '-'
    console = Console(stderr=is_piped, highlight=False)
    domain_id = free_domain_id()
    runs: list[LiveRun] = []
    try:
        with tempfile.TemporaryDirectory(prefix='relations_live_') as folder:
            # The profile for large clouds must be known before DDS starts in this process.
            os.environ.update(local_graph(domain_id, Path(folder) / 'log'))
            for name in args.stream or DEFAULT_STREAMS:
                console.print(f'{name}: {options.duration_sec:g} s at {options.rate:g} Hz')
                layout = stream_format(name)
                runs.append(measure(layout, options, domain_id, Path(folder) / name))
    except SpatialRelationsError as error:
        console.print(f'[red]failed:[/red] {error}', soft_wrap=True)
        return 2
    except KeyboardInterrupt:
        return 130
    _show(console, runs)
    content = {
        'runs': [run_entry(run) for run in runs],
        'models': options.with_models,
        'all_pairs': options.all_pairs,
        'reliable': options.is_reliable,
        'provenance': json.loads(args.provenance),
    }
    text = json.dumps(content, indent=1) + '\n'
    if is_piped:
        sys.stdout.write(text)
    elif args.json is not None:
        _write(args.json, text)
    if args.markdown is not None:
        _write(args.markdown, markdown_table(runs))
    return 1 if any(run.problems for run in runs) else 0


def _show(console: Console, runs: Sequence[LiveRun]) -> None:
    table = Table(box=None, header_style='bold')
    for column in COLUMNS:
        table.add_column(column, overflow='fold')
    for row in table_rows(runs):
        table.add_row(*row)
    console.print(table)
    for run in runs:
        for problem in run.problems:
            console.print(f'{run.stream}: {problem}', style='yellow', soft_wrap=True)
        if run.max_late_ms > 500.0 / run.rate:
            console.print(
                f'{run.stream}: the publisher was late by up to {run.max_late_ms:.0f} ms; the '
                'machine is busy',
                style='yellow',
                soft_wrap=True,
            )


def _write(path: Path, text: str) -> None:
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding='utf-8')


if __name__ == '__main__':
    sys.exit(main())
