"""Reads tracked poses and transforms out of messages, whichever library made them.

No ROS is imported: rclpy's messages and those of a bag reader have the same fields.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypeVar

import numpy as np

from spatial_relations_ros.core import InvalidPoseError, Pose
from spatial_relations_ros.core.rotations import wxyz_from_xyzw
from spatial_relations_ros.perception.border import StampedTransform, TrackedPose, TrackFault
from spatial_relations_ros.perception.series import NS_PER_SEC

Item = TypeVar('Item')
Read = tuple[list[Item], list[TrackFault]]


def stamp_ns(stamp: Any) -> int:
    """Nanoseconds of a ``builtin_interfaces/Time``."""
    return int(stamp.sec) * NS_PER_SEC + int(stamp.nanosec)


def read_pose(pose: Any) -> Pose:
    """A ``geometry_msgs/Pose``.

    Raises:
        InvalidPoseError: when it is not finite or its quaternion is not a rotation.
    """
    return _pose(pose.position, pose.orientation)


def read_transform(transform: Any) -> Pose:
    """A ``geometry_msgs/Transform``.

    Raises:
        InvalidPoseError: when it is not finite or its quaternion is not a rotation.
    """
    return _pose(transform.translation, transform.rotation)


def read_pose_stamped(message: Any, object_id: str) -> Read[TrackedPose]:
    """A ``geometry_msgs/PoseStamped`` of one object, as SimTrack publishes it."""
    return _collect([(object_id, message.header, message.pose, 1.0)])


def read_tracked_objects(message: Any) -> Read[TrackedPose]:
    """A ``spatial_relations_msgs/TrackedObjectArray``."""
    return _collect(
        (
            item.object_id,
            item.header if item.header.frame_id else message.header,
            item.pose,
            float(item.confidence),
        )
        for item in message.objects
    )


def read_detections(message: Any) -> Read[TrackedPose]:
    """A ``vision_msgs/Detection3DArray``.

    Of each detection the hypothesis with the highest score counts; the object's id is the
    detection's, or the class of that hypothesis where the detection has none.
    """
    items = []
    for detection in message.detections:
        if not detection.results:
            continue
        best = max(detection.results, key=lambda result: float(result.hypothesis.score))
        header = detection.header if detection.header.frame_id else message.header
        object_id = detection.id or best.hypothesis.class_id
        items.append((object_id, header, best.pose.pose, float(best.hypothesis.score)))
    return _collect(items)


def read_transforms(message: Any, *, is_static: bool) -> Read[StampedTransform]:
    """A ``tf2_msgs/TFMessage`` of /tf or /tf_static."""
    transforms, faults = [], []
    for item in message.transforms:
        try:
            pose = read_transform(item.transform)
        except InvalidPoseError as error:
            faults.append(TrackFault(item.child_frame_id, f'transform refused: {error}'))
            continue
        parent = item.header.frame_id
        stamp = stamp_ns(item.header.stamp)
        transforms.append(StampedTransform(parent, item.child_frame_id, stamp, pose, is_static))
    return transforms, faults


def _collect(items: Iterable[tuple[str, Any, Any, float]]) -> Read[TrackedPose]:
    tracks, faults = [], []
    for object_id, header, pose, confidence in items:
        try:
            if not object_id:
                raise InvalidPoseError('the tracked object has no id')
            if not np.isfinite(confidence):
                raise InvalidPoseError(f'the confidence is {confidence}')
            frame_from_object = read_pose(pose)
        except InvalidPoseError as error:
            faults.append(TrackFault(object_id, f'tracked pose refused: {error}'))
            continue
        stamp = stamp_ns(header.stamp)
        tracks.append(
            TrackedPose(object_id, stamp, header.frame_id, frame_from_object, confidence)
        )
    return tracks, faults


def _pose(position: Any, quaternion: Any) -> Pose:
    quat_xyzw = np.array([quaternion.x, quaternion.y, quaternion.z, quaternion.w], dtype=float)
    translation = np.array([position.x, position.y, position.z], dtype=float)
    return Pose(translation, wxyz_from_xyzw(quat_xyzw))
