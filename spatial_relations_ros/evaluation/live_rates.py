"""The numbers of the live benchmark: what was sent, handled and how fast, and what it cost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

COLUMNS = (
    'stream', 'MB/s', 'seconds', 'sent', 'received', 'handled', 'latency ms (median, p99)',
    'age ms (median, p99)', 'CPU, one core', 'memory MB (first, last)', 'growth MB/min',
)  # fmt: skip


@dataclass(frozen=True)
class LiveRun:
    """One stream through a perception node.

    Attributes:
        stream: its name.
        rate: clouds a second that were meant to be sent.
        megabytes_per_second: of the clouds.
        duration_sec: from the first to the last cloud.
        num_sent: clouds.
        num_received: clouds that arrived in the node's callback.
        num_handled: clouds that were made scenes of.
        num_scenes_of: clouds of which a scene of each pair reached the subscriber.
        latency_ms: median, 99th percentile and maximum, from the callback to all scenes being
            published, measured in the node.
        ages_ms: one for each scene, from the cloud's stamp, which is taken when it is
            published, to the subscriber's callback.
        cpu_sec: processor time of the node.
        memory_mb: (time in seconds, MB) of the node's resident memory, over the run.
        max_late_ms: by how much the publisher was late at most: on a busy machine clouds are not
            sent at even times.
    """

    stream: str
    rate: float
    megabytes_per_second: float
    duration_sec: float
    num_sent: int
    num_received: int
    num_handled: int
    num_scenes_of: int
    latency_ms: tuple[float, float, float]
    ages_ms: tuple[float, ...]
    cpu_sec: float
    memory_mb: tuple[tuple[float, float], ...]
    max_late_ms: float

    @property
    def cpu_share(self) -> float:
        """Of one core."""
        return self.cpu_sec / self.duration_sec

    @property
    def age_ms(self) -> tuple[float, float]:
        """Median and 99th percentile; NaN when there was no scene."""
        if not self.ages_ms:
            return float('nan'), float('nan')
        median, p99 = np.percentile(self.ages_ms, (50.0, 99.0))
        return float(median), float(p99)

    @property
    def growth(self) -> float:
        """Growth of memory over the second half of the run, MB a minute."""
        return growth_per_minute(self.memory_mb)

    @property
    def problems(self) -> list[str]:
        """What falls short of a node that keeps up: loss of clouds or scenes."""
        found = []
        if self.num_received < self.num_sent:
            found.append(f'{self.num_sent - self.num_received} clouds were not received')
        if self.num_handled < self.num_received:
            found.append(f'{self.num_received - self.num_handled} clouds were not handled')
        if self.num_scenes_of < self.num_handled:
            found.append(f'of {self.num_handled - self.num_scenes_of} clouds no scenes came out')
        return found


def growth_per_minute(memory_mb: Sequence[tuple[float, float]]) -> float:
    """Slope of memory over time, MB a minute, by least squares over the second half.

    The first half holds what is filled once, such as caches and queues.

    Args:
        memory_mb: (seconds, MB).

    Returns:
        NaN for fewer than six samples.
    """
    half = list(memory_mb)[len(memory_mb) // 2 :]
    if len(half) < 3:
        return float('nan')
    seconds, megabytes = np.array(half).T
    seconds = seconds - seconds.mean()
    return float(60.0 * (seconds @ megabytes) / (seconds @ seconds))


def run_entry(run: LiveRun) -> dict[str, Any]:
    """One run as JSON content."""
    age_median, age_p99 = run.age_ms
    median, p99, maximum = run.latency_ms
    return {
        'stream': run.stream,
        'rate_hz': run.rate,
        'megabytes_per_second': run.megabytes_per_second,
        'duration_sec': run.duration_sec,
        'sent': run.num_sent,
        'received': run.num_received,
        'handled': run.num_handled,
        'clouds_with_all_scenes': run.num_scenes_of,
        'latency_ms': {'median': median, 'p99': p99, 'max': maximum},
        'age_ms': {'median': age_median, 'p99': age_p99},
        'cpu_share': run.cpu_share,
        'memory_mb': [[round(value, 2) for value in sample] for sample in run.memory_mb],
        'growth_mb_per_minute': run.growth,
        'publisher_max_late_ms': run.max_late_ms,
        'problems': run.problems,
    }


def table_rows(runs: Sequence[LiveRun]) -> list[tuple[str, ...]]:
    """Rows under ``COLUMNS``."""
    return [
        (
            run.stream,
            f'{run.megabytes_per_second:.0f}',
            f'{run.duration_sec:.0f}',
            str(run.num_sent),
            str(run.num_received),
            str(run.num_handled),
            f'{run.latency_ms[0]:.1f}, {run.latency_ms[1]:.1f}',
            f'{run.age_ms[0]:.1f}, {run.age_ms[1]:.1f}',
            f'{100 * run.cpu_share:.0f} %',
            f'{run.memory_mb[0][1]:.0f}, {run.memory_mb[-1][1]:.0f}',
            f'{run.growth:.2f}',
        )
        for run in runs
    ]


def markdown_table(runs: Sequence[LiveRun]) -> str:
    """The runs as a Markdown table."""
    lines = [COLUMNS, ('---',) * len(COLUMNS), *table_rows(runs)]
    return ''.join(f'| {" | ".join(line)} |\n' for line in lines)
