"""What commands print and write."""

from __future__ import annotations

import json
import math
import os
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Protocol

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table

STDOUT = '-'
LINE_BREAK = re.compile(r'\n\s*')

JsonOption = Annotated[
    Path | None,
    typer.Option(
        '--json',
        metavar='OUT',
        help='Write the results as JSON to this file; - for standard output.',
        show_default=False,
    ),
]


class Advance(Protocol):
    """Tells a progress bar how far the work is."""

    def __call__(self, done: int, total: int, note: str = '') -> None:
        """``done`` of ``total`` steps; ``note`` is shown behind the bar."""


class Output:
    """Where a command's results go.

    With ``--json -`` standard output holds the JSON alone and text goes to standard error.

    Args:
        json_path: of the ``--json`` option.
    """

    def __init__(self, json_path: Path | None = None) -> None:
        self._json_path = json_path
        self.console = Console(stderr=self._to_stdout, highlight=False)
        if json_path is not None and not self._to_stdout:
            check_file(json_path, '--json')

    @property
    def _to_stdout(self) -> bool:
        return self._json_path is not None and str(self._json_path) == STDOUT

    def write_json(self, content: Mapping[str, Any]) -> None:
        """Writes the results where ``--json`` says, if it was given."""
        if self._json_path is None:
            return
        text = json_text(content)
        if self._to_stdout:
            sys.stdout.write(text)
            sys.stdout.flush()
            return
        from spatial_relations_ros.core import atomic_write

        with atomic_write(self._json_path) as temporary:
            temporary.write_text(text)

    def table(
        self, columns: Sequence[str], rows: Sequence[Sequence[object]], *, title: str = ''
    ) -> None:
        """Prints a table; numbers stand at the right."""
        table = Table(
            title=escape(title) or None, title_justify='left', header_style='bold', box=None
        )
        for idx, column in enumerate(columns):
            numeric = bool(rows) and all(isinstance(row[idx], int | float) for row in rows)
            table.add_column(column, justify='right' if numeric else 'left', overflow='fold')
        for row in rows:
            table.add_row(*(_shown(value) for value in row))
        self.console.print(table)

    def say(self, text: str) -> None:
        """Prints a line; Rich markup is understood."""
        self.console.print(text, soft_wrap=True)


def json_text(content: Mapping[str, Any]) -> str:
    """JSON with an end of line; numbers that JSON cannot hold become null.

    A list of numbers or words stands on one line.
    """
    text = json.dumps(_plain(content), indent=2, allow_nan=False)
    # Within JSON strings a line break is always escaped: the breaks matched here are layout.
    flat = re.compile(r'\[\n\s+([^][{}]*?)\n\s*\]')
    return flat.sub(lambda found: f'[{re.sub(LINE_BREAK, " ", found[1])}]', text) + '\n'


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, str) or value is None or isinstance(value, bool):
        return value
    if hasattr(value, 'tolist'):
        return _plain(value.tolist())
    if isinstance(value, Sequence):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _shown(value: object) -> str:
    return f'{value:.4g}' if isinstance(value, float) else escape(str(value))


def check_file(path: Path | None, option: str) -> None:
    """Refuses a file that cannot be written, before the work and not after it.

    Raises:
        typer.BadParameter: naming the option.
    """
    if path is None:
        return
    if path.is_dir():
        raise typer.BadParameter(f'{path} is a folder; {option} takes a file')
    check_folder(path.parent, option)


def check_folder(folder: Path | None, option: str) -> None:
    """Refuses a folder that cannot be made or written into, before the work.

    Raises:
        typer.BadParameter: naming the option.
    """
    if folder is None:
        return
    there = folder
    while not there.exists():
        there = there.parent
    if not there.is_dir():
        raise typer.BadParameter(f'{option}: {there} is a file, not a folder')
    if not os.access(there, os.W_OK):
        raise typer.BadParameter(f'{option}: {there} cannot be written into')


@contextmanager
def progress_bar(description: str) -> Iterator[Advance]:
    """A progress bar with the time left, on standard error."""
    progress = Progress(
        TextColumn('{task.description}'),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn('left'),
        TimeRemainingColumn(),
        TextColumn('{task.fields[note]}'),
        console=Console(stderr=True),
        transient=True,
    )
    with progress:
        task = progress.add_task(description, total=None, note='')

        def advance(done: int, total: int, note: str = '') -> None:
            progress.update(task, completed=done, total=total, note=note)

        yield advance
