"""Finds where a relation is demonstrated: where two objects hold still to each other."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

from spatial_relations_ros.core import ConfigError, Pose
from spatial_relations_ros.perception.series import NS_PER_SEC


@dataclass(frozen=True)
class HoldConfig:
    """When a relation holds still.

    Attributes:
        hold_sec: for at least this long.
        shift: how far the relative may move in the base's frame, metres.
        turn_rad: how far it may turn there.
        max_gap_sec: it may be out of sight, or away for as long as a tracker errs, for at most
            this long.
    """

    hold_sec: float = 1.0
    shift: float = 0.01
    turn_rad: float = math.radians(5.0)
    max_gap_sec: float = 0.5

    def __post_init__(self) -> None:
        values = (self.hold_sec, self.shift, self.turn_rad, self.max_gap_sec)
        if not all(math.isfinite(value) and value > 0 for value in values):
            raise ConfigError(f'limits of a hold must be positive, got {self}')


@dataclass(frozen=True)
class RelationSample:
    """How two objects stand to each other in one frame.

    Attributes:
        frame_idx: of the frame.
        stamp_ns: its time.
        base_from_relative: None when either is not seen.
    """

    frame_idx: int
    stamp_ns: int
    base_from_relative: Pose | None


@dataclass(frozen=True)
class Demonstration:
    """A time for which a relation holds still.

    Attributes:
        first_frame: where it begins.
        settled_frame: the first one at which it has held for long enough.
        last_frame: where it ends, so far.
        start_ns: time of ``first_frame``.
        end_ns: time of ``last_frame``.
    """

    first_frame: int
    settled_frame: int
    last_frame: int
    start_ns: int
    end_ns: int


@dataclass(frozen=True)
class _Hold:
    """Frames in which the relation is that of the first one."""

    first: RelationSample
    last: RelationSample
    settled: RelationSample | None = None

    @property
    def demonstration(self) -> Demonstration | None:
        if self.settled is None:
            return None
        return Demonstration(
            self.first.frame_idx,
            self.settled.frame_idx,
            self.last.frame_idx,
            self.first.stamp_ns,
            self.last.stamp_ns,
        )


class DemonstrationFinder:
    """Finds demonstrations while frames come.

    Poses are compared with that of the hold's first frame, so that slow drifts end it.

    Args:
        config: when a relation holds still.
    """

    def __init__(self, config: HoldConfig | None = None) -> None:
        self._config = config or HoldConfig()
        self._hold: _Hold | None = None
        self._away: list[RelationSample] = []
        self._ended: list[Demonstration] = []

    @property
    def found(self) -> tuple[Demonstration, ...]:
        """All so far, the one that is going on included."""
        current = None if self._hold is None else self._hold.demonstration
        return (*self._ended, *([] if current is None else [current]))

    def add(self, sample: RelationSample) -> Demonstration | None:
        """Takes the next frame; gives the demonstration that it belongs to, or None."""
        hold = self._hold
        if hold is not None and self._is_over(hold, sample):
            self._end()
            hold = self._hold
        pose = sample.base_from_relative
        if pose is None:
            return None
        if hold is None:
            self._hold = _Hold(sample, sample)
            return None
        if not self._is_same(hold, pose):
            self._away.append(sample)
            return None
        self._away.clear()
        settled = hold.settled
        held_sec = (sample.stamp_ns - hold.first.stamp_ns) / NS_PER_SEC
        if settled is None and held_sec >= self._config.hold_sec:
            settled = sample
        self._hold = replace(hold, last=sample, settled=settled)
        return self._hold.demonstration

    def _is_same(self, hold: _Hold, pose: Pose) -> bool:
        first = hold.first.base_from_relative
        assert first is not None
        return first.is_close(pose, metres=self._config.shift, angle_rad=self._config.turn_rad)

    def _is_over(self, hold: _Hold, sample: RelationSample) -> bool:
        """Whether it was left for too long before this frame, or the clock has jumped back."""
        gap_sec = (sample.stamp_ns - hold.last.stamp_ns) / NS_PER_SEC
        return not 0.0 <= gap_sec <= self._config.max_gap_sec

    def _end(self) -> None:
        """Ends the hold; what came since may belong to the next one."""
        assert self._hold is not None
        if self._hold.demonstration is not None:
            self._ended.append(self._hold.demonstration)
        self._hold, away = None, self._away
        self._away = []
        for sample in away:
            self.add(sample)


def find_demonstrations(
    samples: Iterable[RelationSample], config: HoldConfig | None = None
) -> tuple[Demonstration, ...]:
    """All demonstrations in frames in the order in which they came."""
    finder = DemonstrationFinder(config)
    for sample in samples:
        finder.add(sample)
    return finder.found
