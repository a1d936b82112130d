"""What has arrived between two clouds."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterable

from spatial_relations_ros.perception.border import StampedTransform, TrackedPose, TrackFault
from spatial_relations_ros.ros.tracking_messages import Track

# More than seconds of fast trackers; without clouds the oldest go first.
MAX_ITEMS = 5000


class Inbox:
    """Tracked poses and transforms until the next cloud takes them; safe across threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._tracks: deque[TrackedPose] = deque(maxlen=MAX_ITEMS)
        self._transforms: deque[StampedTransform] = deque(maxlen=MAX_ITEMS)
        self._static: dict[str, StampedTransform] = {}
        self._faults: dict[str, TrackFault] = {}

    def add_tracks(self, tracks: Iterable[Track]) -> None:
        """Adds what a tracker sent."""
        with self._lock:
            for track in tracks:
                if isinstance(track, TrackFault):
                    self._add_fault(track)
                else:
                    self._tracks.append(track)

    def add_transforms(
        self, transforms: Iterable[StampedTransform], faults: Iterable[TrackFault]
    ) -> None:
        """Adds what came on /tf or /tf_static."""
        with self._lock:
            for transform in transforms:
                if transform.is_static:  # never crowded out: it is sent only once
                    self._static[transform.child_frame] = transform
                else:
                    self._transforms.append(transform)
            for fault in faults:
                self._add_fault(fault)

    def _add_fault(self, fault: TrackFault) -> None:
        if len(self._faults) < MAX_ITEMS:
            self._faults[fault.object_id] = fault

    def take(
        self,
    ) -> tuple[tuple[TrackedPose, ...], tuple[StampedTransform, ...], tuple[TrackFault, ...]]:
        """Everything so far, in order of arrival; the inbox is empty afterwards."""
        with self._lock:
            taken = (
                tuple(self._tracks),
                (*self._static.values(), *self._transforms),
                tuple(self._faults.values()),
            )
            for box in (self._tracks, self._transforms, self._static, self._faults):
                box.clear()
        return taken
