"""What goes into perception and what comes out: the types at the border to ROS and to bags.

A live node and the reader of a bag make the same ``Frame``; stamps are nanoseconds, frames are
names, and no message type is among them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import Pose, Scene, SceneObject, UnknownObjectError
from spatial_relations_ros.perception.point_cloud2 import PointCloud
from spatial_relations_ros.perception.track_state import TrackStatus


@dataclass(frozen=True, eq=False)
class TrackedPose:
    """A tracker's answer: where an object was at a time.

    Attributes:
        object_id: the tracker's name of the object.
        stamp_ns: time of the image or cloud that the tracker saw.
        frame_id: the frame that the pose is given in, usually the camera's.
        frame_from_object: the pose.
        confidence: 0 to 1 as the tracker says; 1 when it says nothing.
    """

    object_id: str
    stamp_ns: int
    frame_id: str
    frame_from_object: Pose
    confidence: float = 1.0


@dataclass(frozen=True, eq=False)
class StampedTransform:
    """One transform of /tf or /tf_static.

    Attributes:
        parent_frame: header.frame_id of the message.
        child_frame: child_frame_id of the message.
        stamp_ns: time of the transform; without meaning when it is static.
        parent_from_child: the transform.
        is_static: whether it holds at every time.
    """

    parent_frame: str
    child_frame: str
    stamp_ns: int
    parent_from_child: Pose
    is_static: bool = False


@dataclass(frozen=True)
class TrackFault:
    """A tracked pose that could not be read, and why."""

    object_id: str
    reason: str


@dataclass(frozen=True, eq=False)
class Frame:
    """One cloud with everything that has arrived since the cloud before it.

    Attributes:
        stamp_ns: time of the cloud.
        frame_id: the cloud's frame; optical (x right, y down, z forward) when it is organised.
        cloud: the points in ``frame_id``.
        tracks: poses that arrived since the last frame, in order of arrival.
        transforms: transforms that arrived since the last frame, in order of arrival.
        faults: poses that arrived and could not be read.
    """

    stamp_ns: int
    frame_id: str
    cloud: PointCloud
    tracks: tuple[TrackedPose, ...] = ()
    transforms: tuple[StampedTransform, ...] = ()
    faults: tuple[TrackFault, ...] = ()


@dataclass(frozen=True, eq=False)
class FrameResult:
    """The objects that are believed at one cloud's time.

    Attributes:
        stamp_ns: time of the cloud.
        frame_id: name of the world frame, z up, that all poses are in.
        objects: by object id, in the order of the ids.
        rejected: object id -> why it is not among ``objects``, in words.
        states: object id -> how far its tracked pose is believed; empty when there is a problem
            with the whole frame.
        problem: why the whole frame cannot be used, or None.
        table_height: world z of the plane that the objects stand on, metres; None if none is seen.
        obstacles: (N, 3) world points above the table that belong to no object; None when they
            were not asked for.
    """

    stamp_ns: int
    frame_id: str
    objects: Mapping[str, SceneObject] = field(default_factory=dict)
    rejected: Mapping[str, str] = field(default_factory=dict)
    states: Mapping[str, TrackStatus] = field(default_factory=dict)
    problem: str | None = None
    table_height: float | None = None
    obstacles: NDArray[np.float32] | None = None

    def scene(self, base_id: str, relative_id: str) -> Scene:
        """The scene of two objects.

        Raises:
            UnknownObjectError: when an id is not among the objects; the message names those that
                are, and why this one is not.
            InvalidSceneError: when both ids are the same.
        """
        return Scene(
            self._object(base_id), self._object(relative_id), self.stamp_ns, self.frame_id
        )

    def _object(self, object_id: str) -> SceneObject:
        if object_id in self.objects:
            return self.objects[object_id]
        if object_id in self.rejected:
            reason = self.rejected[object_id]
        else:
            reason = self.problem or 'no tracked pose has arrived'
        known = ', '.join(sorted(self.objects)) or 'none'
        raise UnknownObjectError(f'{object_id}: {reason}; known objects: {known}')
