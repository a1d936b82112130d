"""Tracked poses that jump, and ids that change places."""

from __future__ import annotations

import itertools
import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.perception.border import TrackedPose
from spatial_relations_ros.perception.series import NS_PER_SEC

MAX_MOVES = 256
MAX_OBJECTS = 512


@dataclass(frozen=True)
class JumpConfig:
    """What an object cannot do.

    Attributes:
        max_speed: a tracked pose that moves faster from one message to the next has jumped, m/s.
        min_distance: shorter moves are a tracker's jitter, metres.
        settle_sec: how long clouds must confirm an object that has jumped.
        swap_reach: two objects of which each moves at once to within this of the other's place
            have changed places, metres.
        swap_settle_sec: how long clouds must confirm two that have.
        max_hidden_move: an object that is hidden is believed up to this far from where a cloud
            has confirmed it, metres.
    """

    max_speed: float = 3.0
    min_distance: float = 0.05
    settle_sec: float = 1.0
    swap_reach: float = 0.08
    swap_settle_sec: float = 3.0
    max_hidden_move: float = 0.05

    def __post_init__(self) -> None:
        limits = (
            self.max_speed,
            self.min_distance,
            self.settle_sec,
            self.swap_reach,
            self.swap_settle_sec,
            self.max_hidden_move,
        )
        if not all(limit >= 0 for limit in limits):
            raise ConfigError(f'limits of jumps must not be negative, got {self}')


@dataclass(frozen=True, eq=False)
class Move:
    """One step of a tracked pose that is larger than jitter.

    Attributes:
        before: the pose before it.
        after: the pose after it, of the same object in the same frame.
    """

    before: TrackedPose
    after: TrackedPose

    @property
    def distance(self) -> float:
        """Metres."""
        return _distance(self.before, self.after)

    @property
    def duration_sec(self) -> float:
        """From one pose to the other."""
        return (self.after.stamp_ns - self.before.stamp_ns) / NS_PER_SEC


@dataclass(frozen=True)
class Jump:
    """A reason to doubt an object's pose.

    Attributes:
        object_id: whose pose.
        settle_sec: how long clouds must confirm it.
        reason: in words.
        rival_id: the object that it has changed places with, or None.
    """

    object_id: str
    settle_sec: float
    reason: str
    rival_id: str | None = None


class JumpDetector:
    """Looks at consecutive poses of each object, as a tracker sends them.

    Turns are not looked at: trackers turn round objects about their axes at will, which changes
    nothing that can be seen.

    Args:
        config: what counts as a jump.
        max_gap_sec: after a longer silence of a tracker a move is none.
    """

    def __init__(self, config: JumpConfig, *, max_gap_sec: float) -> None:
        self._config = config
        self._max_gap_ns = max_gap_sec * NS_PER_SEC
        # By object and frame: several trackers may follow one object.
        self._last: dict[tuple[str, str], TrackedPose] = {}
        self._recent: deque[Move] = deque(maxlen=MAX_MOVES)
        self._new: deque[Move] = deque(maxlen=MAX_MOVES)

    def add(self, track: TrackedPose) -> None:
        """Takes in a pose; one that is older than the last of its object is passed over."""
        key = track.object_id, track.frame_id
        before = self._last.get(key)
        if before is not None:
            gap_ns = track.stamp_ns - before.stamp_ns
            if -self._max_gap_ns <= gap_ns <= 0:
                return
            is_move = 0 < gap_ns <= self._max_gap_ns
            if is_move and _distance(before, track) > self._config.min_distance:
                self._new.append(Move(before, track))
            del self._last[key]
        elif len(self._last) >= MAX_OBJECTS:
            del self._last[next(iter(self._last))]
        self._last[key] = track

    def take(self) -> list[Jump]:
        """What has jumped since the last call, in order of arrival; swaps come last."""
        config = self._config
        jumps = [
            Jump(
                move.after.object_id,
                config.settle_sec,
                f'the tracked pose jumped by {move.distance:.2f} m in {move.duration_sec:.2f} s',
            )
            for move in self._new
            if move.distance > config.max_speed * move.duration_sec
        ]
        new = list(self._new)
        self._new.clear()
        for first, second in itertools.chain(
            itertools.product(self._recent, new), itertools.combinations(new, 2)
        ):
            if self._is_swap(first, second):
                for move, rival in ((first, second), (second, first)):
                    jumps.append(_swap(move, rival.after.object_id, config))
        if new:
            newest_ns = max(move.after.stamp_ns for move in new)
            self._recent.extend(new)
            while newest_ns - self._recent[0].after.stamp_ns > self._max_gap_ns:
                self._recent.popleft()
        return jumps

    def clear(self) -> None:
        """Forgets everything."""
        self._last.clear()
        self._recent.clear()
        self._new.clear()

    def _is_swap(self, first: Move, second: Move) -> bool:
        if first.after.object_id == second.after.object_id:
            return False
        if first.after.frame_id != second.after.frame_id:
            return False
        if abs(first.after.stamp_ns - second.after.stamp_ns) > self._max_gap_ns:
            return False
        reach = self._config.swap_reach
        return (
            _distance(first.after, second.before) < reach
            and _distance(second.after, first.before) < reach
            # Two that stand next to each other may both be pushed aside.
            and min(first.distance, second.distance) > reach
        )


def _swap(move: Move, rival_id: str, config: JumpConfig) -> Jump:
    reason = (
        f'the tracker made it change places with {rival_id} in {move.duration_sec:.2f} s: '
        'it may have swapped their ids'
    )
    return Jump(move.after.object_id, config.swap_settle_sec, reason, rival_id)


def _distance(first: TrackedPose, second: TrackedPose) -> float:
    offset = first.frame_from_object.translation - second.frame_from_object.translation
    with np.errstate(over='ignore'):
        return math.sqrt(float(offset @ offset))
