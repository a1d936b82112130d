"""How long the parts of a request take."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

PREPARATION, PROPOSALS, EMBEDDING, REFINEMENT, CHECKS = STAGES = (
    'preparation',
    'proposals',
    'embedding',
    'refinement',
    'checks',
)


class Stages:
    """Wall times by part; what runs within another part counts for itself alone."""

    def __init__(self) -> None:
        self._seconds = dict.fromkeys(STAGES, 0.0)
        self._within: list[float] = []

    @property
    def seconds(self) -> Mapping[str, float]:
        """Of each part so far."""
        return dict(self._seconds)

    @contextmanager
    def timed(self, name: str) -> Iterator[None]:
        """Counts what runs in a ``with`` block for a part."""
        start = time.perf_counter()
        self._within.append(0.0)
        try:
            yield
        finally:
            took = time.perf_counter() - start
            self._seconds[name] += took - self._within.pop()
            if self._within:
                self._within[-1] += took
