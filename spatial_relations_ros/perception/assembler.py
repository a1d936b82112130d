"""Puts clouds together with the tracked poses of their time, in whatever order both arrive."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Iterable
from dataclasses import dataclass

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.perception.border import (
    Frame,
    StampedTransform,
    TrackedPose,
    TrackFault,
)
from spatial_relations_ros.perception.frames import clean_frame_id
from spatial_relations_ros.perception.heard_objects import HeardObjects
from spatial_relations_ros.perception.point_cloud2 import PointCloud
from spatial_relations_ros.perception.series import NS_PER_SEC

MAX_WAITING = 4096

OVERRUN = 'newer clouds came before it could be handled'
JUMPED = 'the clock jumped back while it waited'


@dataclass(frozen=True)
class AssemblyConfig:
    """How long a cloud waits for the tracked poses of its time.

    Attributes:
        pose_wait_sec: at most this long after it arrived; 0 takes what is there.
        max_clouds: how many clouds are kept; when so many wait, the first one waits no longer.
        jump_back_sec: a cloud older than the one before by more than this is a restart of the
            clock.
        object_frames: objects whose pose is a frame of /tf of the same name.
    """

    pose_wait_sec: float = 0.1
    max_clouds: int = 5
    jump_back_sec: float = 1.0
    object_frames: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        times = (self.pose_wait_sec, self.jump_back_sec)
        if not all(math.isfinite(value) and value >= 0 for value in times):
            raise ConfigError(f'times must not be negative, got {self}')
        if self.max_clouds < 1:
            raise ConfigError(f'max_clouds is {self.max_clouds}, expected at least 1')


@dataclass(frozen=True, eq=False)
class _WaitingCloud:
    stamp_ns: int
    frame_id: str
    cloud: PointCloud
    arrival_ns: int


class FrameAssembler:
    """Gathers poses, transforms and clouds, and gives one frame for each cloud.

    A cloud waits until each object that is being tracked has a pose at or after its stamp. With
    the cloud go the poses up to there and no later ones: the frames are the same whether poses
    come before or after their cloud, as long as they come within the wait. An object whose poses
    do not is not waited for again until it is heard of.

    All queues are bounded. Not safe to use from several threads.

    Args:
        config: how long clouds wait.

    Attributes:
        dropped: clouds that were given up, counted by reason.
    """

    def __init__(self, config: AssemblyConfig | None = None) -> None:
        self._config = config or AssemblyConfig()
        self._jump_back_ns = round(self._config.jump_back_sec * NS_PER_SEC)
        self._heard = HeardObjects(self._jump_back_ns)
        self._tracks: deque[TrackedPose] = deque(maxlen=MAX_WAITING)
        self._transforms: deque[StampedTransform] = deque(maxlen=MAX_WAITING)
        self._faults: deque[TrackFault] = deque(maxlen=MAX_WAITING)
        self._clouds: deque[_WaitingCloud] = deque()
        self._last_stamp_ns: int | None = None
        self.dropped: Counter[str] = Counter()

    @property
    def num_clouds(self) -> int:
        """How many clouds wait."""
        return len(self._clouds)

    def configure(self, config: AssemblyConfig) -> None:
        """Uses other settings from now on; what waits goes on waiting."""
        self._config = config

    def reset(self) -> None:
        """Forgets everything that waits, and what was counted."""
        for queue in (self._tracks, self._transforms, self._faults, self._clouds):
            queue.clear()
        self._heard = HeardObjects(self._jump_back_ns)
        self._last_stamp_ns = None
        self.dropped.clear()

    def add_tracks(self, tracks: Iterable[TrackedPose], faults: Iterable[TrackFault] = ()) -> None:
        """Keeps tracked poses and those that could not be read."""
        for track in tracks:
            if self._heard.hear(track.object_id, track.stamp_ns):
                self._forget_tracks_after(track.stamp_ns, track.object_id)
            self._tracks.append(track)
        self._faults.extend(faults)

    def add_transforms(
        self, transforms: Iterable[StampedTransform], faults: Iterable[TrackFault] = ()
    ) -> None:
        """Keeps transforms and those that could not be read."""
        for transform in transforms:
            child = clean_frame_id(transform.child_frame)
            if child in self._config.object_frames and not transform.is_static:
                self._heard.hear(child, transform.stamp_ns)
            self._transforms.append(transform)
        self._faults.extend(faults)

    def add_cloud(self, stamp_ns: int, frame_id: str, cloud: PointCloud, now_ns: int) -> None:
        """Queues a cloud; when the queue is full those before it are given up.

        Args:
            stamp_ns: time of the cloud.
            frame_id: the cloud's frame.
            cloud: its points.
            now_ns: when it arrived, on the clock of ``take``.
        """
        last_ns, self._last_stamp_ns = self._last_stamp_ns, stamp_ns
        if last_ns is not None and stamp_ns < last_ns - self._jump_back_ns:
            self._drop_clouds(JUMPED)
            self._heard.forget_after(stamp_ns + self._jump_back_ns)
            self._forget_tracks_after(stamp_ns + self._jump_back_ns)
        elif len(self._clouds) >= self._config.max_clouds:
            self._drop_clouds(OVERRUN)
        self._clouds.append(_WaitingCloud(stamp_ns, frame_id, cloud, now_ns))

    def take(self, now_ns: int | None) -> Frame | None:
        """The frame of the first cloud that waits, once its wait is over.

        Args:
            now_ns: any clock that goes on while messages arrive, nanoseconds: that of the node,
                or the times at which a bag's messages were recorded. None when no more will
                come.

        Returns:
            None when there is no cloud, or its poses may still come.
        """
        if not self._clouds:
            return None
        first = self._clouds[0]
        missing = self._heard.missing_at(first.stamp_ns)
        if missing and not self._is_over(first, now_ns):
            return None
        self._heard.give_up(missing)
        self._clouds.popleft()
        frame = Frame(
            first.stamp_ns,
            first.frame_id,
            first.cloud,
            self._taken_tracks(first.stamp_ns),
            tuple(self._transforms),
            tuple(self._faults),
        )
        self._transforms.clear()
        self._faults.clear()
        return frame

    def _is_over(self, cloud: _WaitingCloud, now_ns: int | None) -> bool:
        if now_ns is None or len(self._clouds) >= self._config.max_clouds:
            return True
        # The clock itself may be set back.
        return not 0 <= now_ns - cloud.arrival_ns < self._config.pose_wait_sec * NS_PER_SEC

    def _taken_tracks(self, stamp_ns: int) -> tuple[TrackedPose, ...]:
        """The poses up to a cloud's stamp and the first one after it; later ones stay."""
        taken = []
        for _ in range(len(self._tracks)):
            track = self._tracks.popleft()
            if self._heard.is_due(track.object_id, track.stamp_ns, stamp_ns):
                taken.append(track)
            else:
                self._tracks.append(track)
        return tuple(taken)

    def _drop_clouds(self, reason: str) -> None:
        if self._clouds:
            self.dropped[reason] += len(self._clouds)
        self._clouds.clear()

    def _forget_tracks_after(self, stamp_ns: int, object_id: str | None = None) -> None:
        """Forgets poses of one object, or of all, that a jump back left in the future."""
        kept = [
            track
            for track in self._tracks
            if track.stamp_ns <= stamp_ns or object_id not in (None, track.object_id)
        ]
        self._tracks.clear()
        self._tracks.extend(kept)
