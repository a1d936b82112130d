"""Which objects are believed: what trackers send and what clouds say, put together."""

from __future__ import annotations

import math
from collections.abc import Mapping

from spatial_relations_ros.perception.border import TrackedPose
from spatial_relations_ros.perception.config import PerceptionConfig
from spatial_relations_ros.perception.jumps import JumpDetector
from spatial_relations_ros.perception.track_state import (
    Evidence,
    Observation,
    TrackMonitor,
    TrackState,
    TrackStatus,
)


class Beliefs:
    """The state of each object over clouds, and who may have been taken for whom."""

    def __init__(self, config: PerceptionConfig) -> None:
        self._settle_sec = config.jumps.settle_sec
        self._jumps = JumpDetector(config.jumps, max_gap_sec=config.tracks.max_age_sec)
        self._monitor = TrackMonitor(config.states)
        self._rivals: dict[str, str] = {}

    def add(self, track: TrackedPose) -> None:
        """Takes in a pose as the tracker sent it."""
        self._jumps.add(track)

    def doubt_jumps(self) -> None:
        """Draws the consequences of all poses since the last cloud."""
        for jump in self._jumps.take():
            self._monitor.doubt(jump.object_id, jump.settle_sec, jump.reason)
            if jump.rival_id is not None:
                self._rivals[jump.object_id] = jump.rival_id

    def doubt_looks(self, object_id: str) -> None:
        """An object without a model is not what it was."""
        reason = 'what is seen at the tracked pose is not what was seen of it before'
        self._monitor.doubt(object_id, self._settle_sec, reason)

    def rival_of(self, object_id: str) -> str | None:
        """The object that this one has changed places with, while that is in doubt."""
        return self._rivals.get(object_id)

    def update(
        self, stamp_ns: int, observations: Mapping[str, Observation]
    ) -> dict[str, TrackStatus]:
        """The states after one cloud; objects that are not mentioned are forgotten."""
        self._monitor.keep(frozenset(observations))
        states = {
            object_id: self._monitor.update(
                object_id, stamp_ns, self._with_rival(object_id, observations)
            )
            for object_id in sorted(observations)
        }
        self._rivals = {
            object_id: rival_id
            for object_id, rival_id in self._rivals.items()
            if object_id in states and states[object_id].state is not TrackState.TRACKED
        }
        return states

    def _with_rival(self, object_id: str, observations: Mapping[str, Observation]) -> Observation:
        """Of two that have changed places neither is right while one is plainly wrong."""
        own = observations[object_id]
        rival_id = self._rivals.get(object_id)
        rival = None if rival_id is None else observations.get(rival_id)
        if rival is None or own.evidence is not Evidence.CONFIRMED:
            return own
        is_refuted = rival.evidence is Evidence.CONTRADICTED and not math.isnan(rival.support)
        reason = f'{rival_id} is not where its tracked pose says'
        return Observation(Evidence.NONE, own.support, reason) if is_refuted else own

    def clear(self) -> None:
        """Forgets everything."""
        self._jumps.clear()
        self._monitor.clear()
        self._rivals.clear()
