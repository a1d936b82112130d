"""Gathers what arrives between two clouds."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

from spatial_relations_ros.perception.border import (
    Frame,
    StampedTransform,
    TrackedPose,
    TrackFault,
)
from spatial_relations_ros.perception.point_cloud2 import PointCloud

MAX_WAITING = 4096


class FrameAssembler:
    """Collects poses and transforms until a cloud comes, in order of arrival.

    What waits is bounded: without clouds the oldest is dropped.
    """

    def __init__(self) -> None:
        self._tracks: deque[TrackedPose] = deque(maxlen=MAX_WAITING)
        self._transforms: deque[StampedTransform] = deque(maxlen=MAX_WAITING)
        self._faults: deque[TrackFault] = deque(maxlen=MAX_WAITING)

    def add_tracks(self, tracks: Iterable[TrackedPose], faults: Iterable[TrackFault] = ()) -> None:
        """Keeps tracked poses and those that could not be read."""
        self._tracks.extend(tracks)
        self._faults.extend(faults)

    def add_transforms(
        self, transforms: Iterable[StampedTransform], faults: Iterable[TrackFault] = ()
    ) -> None:
        """Keeps transforms and those that could not be read."""
        self._transforms.extend(transforms)
        self._faults.extend(faults)

    def frame(self, stamp_ns: int, frame_id: str, cloud: PointCloud) -> Frame:
        """The cloud with everything that came since the last one."""
        frame = Frame(
            stamp_ns,
            frame_id,
            cloud,
            tuple(self._tracks),
            tuple(self._transforms),
            tuple(self._faults),
        )
        self.clear()
        return frame

    def clear(self) -> None:
        """Forgets what waits."""
        self._tracks.clear()
        self._transforms.clear()
        self._faults.clear()
