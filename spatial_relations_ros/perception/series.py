"""A short memory of stamped values."""

from __future__ import annotations

import bisect
from typing import Generic, TypeVar

Value = TypeVar('Value')

NS_PER_SEC = 1_000_000_000


class StampedSeries(Generic[Value]):
    """Values in order of time, bounded in number and age.

    A value that arrives late is sorted in. When time jumps back (a bag starts again, a simulation
    is reset) everything from before the jump is forgotten.

    Args:
        history_ns: how much older than the newest value a value may be.
        max_samples: how many values are kept.
        jump_back_ns: a value older than the newest by more than this is a jump.
    """

    def __init__(self, *, history_ns: int, max_samples: int, jump_back_ns: int) -> None:
        self._history_ns = history_ns
        self._max_samples = max_samples
        self._jump_back_ns = jump_back_ns
        self._stamps: list[int] = []
        self._values: list[Value] = []

    def __len__(self) -> int:
        return len(self._stamps)

    @property
    def newest_ns(self) -> int:
        """Time of the newest value; the series must not be empty."""
        return self._stamps[-1]

    @property
    def oldest_ns(self) -> int:
        """Time of the oldest value; the series must not be empty."""
        return self._stamps[0]

    def add(self, stamp_ns: int, value: Value) -> None:
        """Stores a value; a second one of the same time replaces the first."""
        if self._stamps and stamp_ns < self._stamps[-1] - self._jump_back_ns:
            self.clear()
        idx = bisect.bisect_left(self._stamps, stamp_ns)
        if idx < len(self._stamps) and self._stamps[idx] == stamp_ns:
            self._values[idx] = value
            return
        self._stamps.insert(idx, stamp_ns)
        self._values.insert(idx, value)
        first = bisect.bisect_left(self._stamps, self._stamps[-1] - self._history_ns)
        first = max(first, len(self._stamps) - self._max_samples)
        del self._stamps[:first], self._values[:first]

    def clear(self) -> None:
        """Forgets everything."""
        self._stamps.clear()
        self._values.clear()

    def around(self, stamp_ns: int) -> tuple[tuple[int, Value] | None, tuple[int, Value] | None]:
        """The latest value at or before a time and the first one after it, with their times."""
        idx = bisect.bisect_right(self._stamps, stamp_ns)
        before = (self._stamps[idx - 1], self._values[idx - 1]) if idx else None
        after = (self._stamps[idx], self._values[idx]) if idx < len(self._stamps) else None
        return before, after
