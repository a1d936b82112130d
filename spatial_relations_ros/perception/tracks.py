"""Tracked poses over time, brought to the world."""

from __future__ import annotations

import math
from dataclasses import dataclass

from spatial_relations_ros.core import (
    ConfigError,
    FrameTransformError,
    Pose,
    SpatialRelationsError,
)
from spatial_relations_ros.perception.border import TrackedPose
from spatial_relations_ros.perception.frames import TransformBuffer, interpolate_poses
from spatial_relations_ros.perception.series import NS_PER_SEC, StampedSeries


class TrackRejectedError(SpatialRelationsError):
    """A tracked pose that must not be used now: stale, from the future, or not trusted."""


@dataclass(frozen=True)
class TrackConfig:
    """When a tracked pose is believed.

    Attributes:
        max_age_sec: how old the latest pose may be at the cloud's time; also the longest gap
            that is bridged by interpolation.
        max_ahead_sec: how much later than the cloud a pose may be when none is before it.
        min_confidence: poses that the tracker trusts less are refused.
        history_sec: how long poses are remembered.
        max_objects: how many objects are remembered; the one silent longest is forgotten.
        jump_back_sec: a step back in time by more than this is a restart of the clock.
    """

    max_age_sec: float = 0.5
    max_ahead_sec: float = 0.05
    min_confidence: float = 0.0
    history_sec: float = 5.0
    max_objects: int = 64
    jump_back_sec: float = 1.0

    def __post_init__(self) -> None:
        limits = (self.max_age_sec, self.max_ahead_sec, self.history_sec, self.jump_back_sec)
        if not all(math.isfinite(limit) and limit >= 0 for limit in limits):
            raise ConfigError(f'times must not be negative, got {self}')
        if not 0 <= self.min_confidence <= 1 or self.max_objects < 1:
            raise ConfigError(f'min_confidence is 0 to 1 and max_objects at least 1, got {self}')


class TrackBuffer:
    """The last poses of each object."""

    def __init__(self, config: TrackConfig | None = None) -> None:
        self._config = config or TrackConfig()
        self._series: dict[str, StampedSeries[TrackedPose]] = {}
        # The last that was brought to the world, of each object, and its world_from_object.
        self._placed: dict[str, tuple[TrackedPose, Pose]] = {}

    @property
    def object_ids(self) -> tuple[str, ...]:
        """Ids of all objects that are remembered, sorted."""
        return tuple(sorted(self._series))

    def configure(self, config: TrackConfig) -> None:
        """Uses other limits from now on; poses that are remembered stay."""
        self._config = config

    def add(self, track: TrackedPose) -> None:
        """Stores a pose."""
        config = self._config
        # Taken out and put back: the dict stays in order of the last word of each object.
        series = self._series.pop(track.object_id, None) or StampedSeries(
            history_ns=round(config.history_sec * NS_PER_SEC),
            max_samples=1000,
            jump_back_ns=round(config.jump_back_sec * NS_PER_SEC),
        )
        series.add(track.stamp_ns, track)
        self._series[track.object_id] = series
        if len(self._series) > config.max_objects:
            oldest = next(iter(self._series))
            del self._series[oldest]
            self._placed.pop(oldest, None)

    def clear(self) -> None:
        """Forgets everything."""
        self._series.clear()
        self._placed.clear()

    def world_from_object(
        self, object_id: str, stamp_ns: int, transforms: TransformBuffer, world_frame: str
    ) -> Pose:
        """An object's pose in the world at a time.

        Between two poses it is interpolated in the world, so that a camera that moves does not
        matter; after the last one that pose is held until it is too old.

        Raises:
            TrackRejectedError: when no pose of that time is believed.
            FrameTransformError: when the tracker's frame cannot be brought to the world.
        """
        before, after = self._series[object_id].around(stamp_ns)
        max_age_ns = self._config.max_age_sec * NS_PER_SEC
        if before and after and after[0] - before[0] <= max_age_ns:
            if before[0] == stamp_ns:
                return self._in_world(before[1], transforms, world_frame)
            return interpolate_poses(
                self._in_world(before[1], transforms, world_frame),
                self._in_world(after[1], transforms, world_frame),
                (stamp_ns - before[0]) / (after[0] - before[0]),
            )
        if before and stamp_ns - before[0] <= max_age_ns:
            return self._in_world(before[1], transforms, world_frame)
        if after and after[0] - stamp_ns <= self._config.max_ahead_sec * NS_PER_SEC:
            return self._in_world(after[1], transforms, world_frame)
        if before:
            age = (stamp_ns - before[0]) / NS_PER_SEC
            raise TrackRejectedError(
                f'the last tracked pose is {age:.2f} s old, '
                f'at most {self._config.max_age_sec:.2f} s are allowed'
            )
        assert after is not None  # a series that is remembered is never empty
        ahead = (after[0] - stamp_ns) / NS_PER_SEC
        raise TrackRejectedError(f'the first tracked pose is {ahead:.2f} s later than the cloud')

    def _in_world(self, track: TrackedPose, transforms: TransformBuffer, world_frame: str) -> Pose:
        if track.confidence < self._config.min_confidence:
            raise TrackRejectedError(
                f'the tracker trusts its pose with {track.confidence:.2f} only, '
                f'at least {self._config.min_confidence:.2f} are needed'
            )
        placed, pose = self._placed.get(track.object_id, (None, None))
        try:
            world_from_frame = transforms.lookup(world_frame, track.frame_id, track.stamp_ns)
        except FrameTransformError:
            if placed is not track or pose is None:
                raise
            return pose  # transforms of a time that is no longer remembered
        pose = world_from_frame @ track.frame_from_object
        self._placed[track.object_id] = track, pose
        return pose
