"""How long a node takes from a message's arrival in the callback to its results being out."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict, deque

import numpy as np

# Eleven minutes at 30 Hz.
MAX_KEPT = 20_000
# More than ever wait to be handled.
MAX_PENDING = 64


class Latencies:
    """Times of the messages since the start or the last ``clear``, by their stamps.

    Safe to use from several threads.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._pending: OrderedDict[int, float] = OrderedDict()
        self._seconds: deque[float] = deque(maxlen=MAX_KEPT)
        self._num_done = 0

    @property
    def num_done(self) -> int:
        """How many messages were handled."""
        return self._num_done

    def arrived(self, stamp_ns: int) -> None:
        """A message has come."""
        with self._lock:
            self._pending[stamp_ns] = time.monotonic()
            if len(self._pending) > MAX_PENDING:
                self._pending.popitem(last=False)

    def done(self, stamp_ns: int) -> None:
        """What it led to is published."""
        now_sec = time.monotonic()
        with self._lock:
            self._num_done += 1
            arrival_sec = self._pending.pop(stamp_ns, None)
            if arrival_sec is not None:
                self._seconds.append(now_sec - arrival_sec)

    def clear(self) -> None:
        """Forgets everything."""
        with self._lock:
            self._pending.clear()
            self._seconds.clear()
            self._num_done = 0

    def values(self) -> dict[str, object]:
        """For diagnostics: how many, median, 99th percentile and maximum in milliseconds."""
        with self._lock:
            milliseconds = 1e3 * np.array(self._seconds)
            values: dict[str, object] = {'handled': self._num_done}
        if len(milliseconds):
            median, p99 = np.percentile(milliseconds, (50.0, 99.0))
            values |= {
                'latency_median_ms': f'{median:.1f}',
                'latency_p99_ms': f'{p99:.1f}',
                'latency_max_ms': f'{milliseconds.max():.1f}',
            }
        return values
