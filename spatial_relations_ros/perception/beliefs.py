"""Which objects are believed: what trackers send and what clouds say, put together."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import Pose
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
        self._config = config.jumps
        self._jumps = JumpDetector(config.jumps, max_gap_sec=config.tracks.max_age_sec)
        self._monitor = TrackMonitor(config.states)
        self._rivals: dict[str, str] = {}
        self._seen_at: dict[str, NDArray[np.float64]] = {}

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
        self._monitor.doubt(object_id, self._config.settle_sec, reason)

    def rival_of(self, object_id: str) -> str | None:
        """The object that this one has changed places with, while that is in doubt."""
        return self._rivals.get(object_id)

    def update(
        self,
        stamp_ns: int,
        observations: Mapping[str, Observation],
        poses: Mapping[str, Pose],
    ) -> dict[str, TrackStatus]:
        """The states after one cloud.

        Args:
            stamp_ns: time of the cloud.
            observations: what it says of each object; others are forgotten.
            poses: ``world_from_object`` of those that have one.
        """
        self._monitor.keep(frozenset(observations))
        for object_id, pose in poses.items():
            self._doubt_hidden_move(object_id, pose, observations[object_id])
        states = {
            object_id: self._monitor.update(
                object_id, stamp_ns, self._with_rival(object_id, observations)
            )
            for object_id in sorted(observations)
        }
        self._seen_at = {key: place for key, place in self._seen_at.items() if key in states}
        self._rivals = {
            object_id: rival_id
            for object_id, rival_id in self._rivals.items()
            if object_id in states and states[object_id].state is not TrackState.TRACKED
        }
        return states

    def _doubt_hidden_move(self, object_id: str, pose: Pose, observation: Observation) -> None:
        """What is hidden is believed where it was; a tracker can only guess where it went."""
        if observation.evidence is Evidence.CONFIRMED:
            self._seen_at[object_id] = pose.translation
        elif observation.evidence is Evidence.NONE and object_id in self._seen_at:
            distance = float(np.linalg.norm(pose.translation - self._seen_at[object_id]))
            if distance > self._config.max_hidden_move:
                reason = f'it moved by {distance:.2f} m since it was last seen'
                self._monitor.doubt(object_id, 0.0, reason)

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
        self._seen_at.clear()
