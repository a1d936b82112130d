"""Wall and processor times of repeated steps, and their rows in tables."""

from __future__ import annotations

import resource
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

NUM_WARM_UPS = 2
MIN_RUNS = 3


@dataclass(frozen=True)
class Timing:
    """Wall times of one step.

    Attributes:
        name: of the step.
        seconds: one for each run, warm-up left out.
        cpu_seconds: of all threads, one for each run; empty where it was not measured.
    """

    name: str
    seconds: tuple[float, ...]
    cpu_seconds: tuple[float, ...] = ()

    @property
    def median(self) -> float:
        """Seconds."""
        return float(np.median(self.seconds))

    def where(self, name: str, chosen: Sequence[bool]) -> Timing:
        """Some of the runs under another name; ``chosen`` counts the warm-up too."""
        picked = np.flatnonzero(chosen[NUM_WARM_UPS:])
        return Timing(
            name,
            tuple(self.seconds[idx] for idx in picked),
            tuple(self.cpu_seconds[idx] for idx in picked),
        )

    @property
    def cpu_median(self) -> float:
        """Seconds of the processor; NaN where it was not measured."""
        return float(np.median(self.cpu_seconds)) if self.cpu_seconds else float('nan')

    @property
    def p90(self) -> float:
        """Seconds."""
        return float(np.percentile(self.seconds, 90))


def peak_memory_mib() -> float:
    """The most memory that this process has held, MiB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def ratio_rows(timings: Sequence[Timing]) -> list[dict[str, float | str]]:
    """How many times slower the paper's or the usual way is, where both were timed, by medians."""
    by_name = {timing.name: timing for timing in timings}
    pairs = (
        ('imitate', 'imitate as the paper'),
        ('pose gradient', 'pose gradient of the paper'),
        ('reader', 'reader by structured array'),
        ('network', 'network in bfloat16'),
        ('network compiled', 'network not compiled'),
    )
    return [
        {'step': ours, 'than': other, 'ratio': by_name[other].median / by_name[ours].median}
        for ours, other in pairs
        if ours in by_name and other in by_name
    ]


def timing_rows(timings: Sequence[Timing]) -> list[dict[str, float | int | str]]:
    """Timings as JSON content."""
    return [
        {
            'step': timing.name,
            'runs': len(timing.seconds),
            'median': timing.median,
            'p90': timing.p90,
            'cpu_median': timing.cpu_median,
            'min': min(timing.seconds),
            'max': max(timing.seconds),
        }
        for timing in timings
    ]
