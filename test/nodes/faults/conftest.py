"""Fixtures of the fault tests, and the table that a run of them prints."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass

import pytest


@dataclass
class FaultRow:
    """One fault: what was done, what the node said, how long until all was well again."""

    fault: str
    said: str = ''
    over_sec: float | None = None
    back: str = ''

    def is_over(self) -> None:
        """From here on the time until all is well counts."""
        self.over_sec = time.monotonic()

    def is_back(self, what: str = '') -> None:
        """All is well again; ``what`` it took besides time."""
        assert self.over_sec is not None
        self.back = f'{what and what + ", "}{time.monotonic() - self.over_sec:.1f} s'


Faults = Callable[[str], AbstractContextManager[FaultRow]]
_ROWS = pytest.StashKey[list[FaultRow]]()


@contextmanager
def _written(rows: list[FaultRow], fault: str) -> Iterator[FaultRow]:
    """A row of the table; nothing is written of a test that fails."""
    row = FaultRow(fault)
    yield row
    rows.append(row)


@pytest.fixture(scope='session')
def faults(pytestconfig: pytest.Config) -> Faults:
    rows = pytestconfig.stash.setdefault(_ROWS, [])
    return lambda fault: _written(rows, fault)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    rows = terminalreporter.config.stash.get(_ROWS, [])
    if not rows:
        return
    terminalreporter.section('faults')
    terminalreporter.write_line('| Fault | What is said | Well again after |')
    terminalreporter.write_line('|---|---|---|')
    for row in rows:
        terminalreporter.write_line(f'| {row.fault} | {row.said} | {row.back} |')
