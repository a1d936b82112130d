"""Whether an object's tracked pose is believed, over time."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.perception.series import NS_PER_SEC


class TrackState(enum.StrEnum):
    """How far a tracked pose is believed.

    TRACKED: it is used. UNCERTAIN: something speaks against it, or has until a moment ago.
    LOST: it has had no support for longer than that.
    """

    TRACKED = 'TRACKED'
    UNCERTAIN = 'UNCERTAIN'
    LOST = 'LOST'


class Evidence(enum.Enum):
    """What one cloud says about a tracked pose."""

    CONFIRMED = 'the object is seen there, or there is no way to check'
    WEAK = 'so little of it is seen that it neither makes nor breaks a belief'
    NONE = 'the place is hidden, or nothing came back from there'
    CONTRADICTED = 'the object is not there, or its pose cannot be used'


@dataclass(frozen=True)
class Observation:
    """The evidence of one cloud.

    Attributes:
        evidence: what it says.
        support: share of the visible surface that is confirmed, 0 to 1; NaN when not checked.
        reason: in words, when it does not confirm.
    """

    evidence: Evidence
    support: float = math.nan
    reason: str = ''


@dataclass(frozen=True)
class TrackStateConfig:
    """How beliefs change.

    Attributes:
        lost_after_sec: a pose that was good longer ago than this, and is contradicted, is lost.
        recover_sec: how long a lost object must be confirmed without a break.
    """

    lost_after_sec: float = 0.5
    recover_sec: float = 0.3

    def __post_init__(self) -> None:
        if not (0 <= self.lost_after_sec < math.inf and 0 <= self.recover_sec < math.inf):
            raise ConfigError(f'times must not be negative, got {self}')


@dataclass(frozen=True)
class TrackStatus:
    """The belief in one object's pose at one cloud.

    Attributes:
        state: see ``TrackState``.
        support: share of the visible surface that the cloud confirms; NaN when not checked.
        reason: why it is not TRACKED, in words; empty when it is.
        last_good_ns: time of the last cloud at which it was TRACKED and not contradicted; None
            before the first.
    """

    state: TrackState
    support: float = math.nan
    reason: str = ''
    last_good_ns: int | None = None


@dataclass
class _Belief:
    """What is remembered of one object."""

    state: TrackState | None = None
    last_good_ns: int | None = None
    good_since_ns: int | None = None
    # How long it must be confirmed before it is TRACKED again, and why.
    settle_sec: float = 0.0
    doubt: str = ''


class TrackMonitor:
    """Weighs the evidence of one cloud after the other, with hysteresis.

    One contradicting cloud is enough to stop using a pose; it takes less to keep a belief than to
    gain one, and a lost object must be confirmed for a while.
    """

    def __init__(self, config: TrackStateConfig | None = None) -> None:
        self._config = config or TrackStateConfig()
        self._beliefs: dict[str, _Belief] = {}

    def doubt(self, object_id: str, settle_sec: float, reason: str) -> None:
        """Stops believing an object until clouds have confirmed it for ``settle_sec``."""
        belief = self._beliefs.setdefault(object_id, _Belief())
        belief.good_since_ns = None
        belief.settle_sec = max(belief.settle_sec, settle_sec)
        belief.doubt = reason
        if belief.state is not TrackState.LOST:
            belief.state = TrackState.UNCERTAIN

    def update(self, object_id: str, stamp_ns: int, seen: Observation) -> TrackStatus:
        """Takes in what one cloud says of one object."""
        belief = self._beliefs.setdefault(object_id, _Belief())
        if seen.evidence is Evidence.CONTRADICTED:
            self._contradict(belief, stamp_ns)
        elif seen.evidence is Evidence.CONFIRMED:
            self._confirm(belief, stamp_ns)
        elif belief.state is None:  # a new object must be seen once
            belief.state = TrackState.UNCERTAIN
        elif belief.state is not TrackState.TRACKED:
            belief.good_since_ns = None
        assert belief.state is not None
        if belief.state is TrackState.TRACKED:
            belief.last_good_ns = stamp_ns
            return TrackStatus(belief.state, seen.support, '', stamp_ns)
        reason = self._reason(belief, stamp_ns, seen)
        return TrackStatus(belief.state, seen.support, reason, belief.last_good_ns)

    def keep(self, object_ids: frozenset[str]) -> None:
        """Forgets all other objects."""
        for object_id in self._beliefs.keys() - object_ids:
            del self._beliefs[object_id]

    def clear(self) -> None:
        """Forgets everything."""
        self._beliefs.clear()

    def _contradict(self, belief: _Belief, stamp_ns: int) -> None:
        belief.good_since_ns = None
        last_ns = belief.last_good_ns
        lost_after_ns = self._config.lost_after_sec * NS_PER_SEC
        if last_ns is not None and stamp_ns - last_ns <= lost_after_ns:
            belief.state = TrackState.UNCERTAIN
            return
        belief.state = TrackState.LOST
        if belief.settle_sec <= self._config.recover_sec:
            belief.settle_sec, belief.doubt = self._config.recover_sec, 'it was lost'

    def _confirm(self, belief: _Belief, stamp_ns: int) -> None:
        if belief.good_since_ns is None:
            belief.good_since_ns = stamp_ns
        if stamp_ns - belief.good_since_ns >= belief.settle_sec * NS_PER_SEC:
            belief.state = TrackState.TRACKED
            belief.settle_sec, belief.doubt = 0.0, ''
        else:
            belief.state = TrackState.UNCERTAIN

    def _reason(self, belief: _Belief, stamp_ns: int, seen: Observation) -> str:
        if seen.evidence is Evidence.CONFIRMED and belief.good_since_ns is not None:
            confirmed_sec = (stamp_ns - belief.good_since_ns) / NS_PER_SEC
            why = (
                f'{belief.doubt}; confirmed for {confirmed_sec:.1f} s since, '
                f'{belief.settle_sec:.1f} s are needed'
            )
        else:
            why = seen.reason
            if seen.evidence is not Evidence.CONTRADICTED and belief.doubt:
                why = f'{belief.doubt}; {seen.reason}'
        if belief.last_good_ns is None:
            return f'{why}, never confirmed'
        return f'{why}, last good {max(0, stamp_ns - belief.last_good_ns) / NS_PER_SEC:.1f} s ago'
