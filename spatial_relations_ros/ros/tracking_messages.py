"""Tracked poses and transforms, from every message that trackers publish them in."""

from __future__ import annotations

from typing import Any

from spatial_relations_ros.core import ConfigError, SpatialRelationsError
from spatial_relations_ros.perception.border import StampedTransform, TrackedPose, TrackFault
from spatial_relations_ros.ros.conversions import (
    pose_from_msg,
    pose_from_transform_msg,
    stamp_ns_from_msg,
)

Track = TrackedPose | TrackFault


def pose_topic(entry: str) -> tuple[str, str]:
    """Object id and topic of one entry of ``pose_topics``.

    ``/simtrack/bowl`` is the topic of the object ``bowl``; ``cup=/some/pose`` names the object.

    Raises:
        ConfigError: for an entry without an object id or a topic.
    """
    object_id, separator, topic = entry.partition('=')
    if not separator:
        object_id, topic = entry.rstrip('/').rpartition('/')[2], entry
    if not object_id or not topic:
        raise ConfigError(f'pose_topics has {entry!r}; expected "/topic/id" or "id=/topic"')
    return object_id, topic


def track(object_id: str, header: Any, pose: Any, confidence: float = 1.0) -> Track:
    """A tracked pose of a header and a geometry_msgs/Pose, or why it cannot be read."""
    try:
        if not header.frame_id:
            return TrackFault(object_id, 'the pose comes without a frame_id')
        return TrackedPose(
            object_id=object_id,
            stamp_ns=stamp_ns_from_msg(header.stamp),
            frame_id=header.frame_id.lstrip('/'),
            frame_from_object=pose_from_msg(pose),
            confidence=confidence,
        )
    except SpatialRelationsError as error:
        return TrackFault(object_id, str(error))


def tracks_of_array(msg: Any) -> list[Track]:
    """Of a TrackedObjectArray; an object without a frame takes the array's header."""
    return [
        track(
            tracked.object_id,
            tracked.header if tracked.header.frame_id else msg.header,
            tracked.pose,
            float(tracked.confidence),
        )
        for tracked in msg.objects
    ]


def tracks_of_detections(msg: Any) -> list[Track]:
    """Of a vision_msgs/Detection3DArray.

    The object's id is the detection's ``id``, else the class of its best hypothesis; the pose and
    the confidence are those of that hypothesis, else the box's centre.
    """
    tracks: list[Track] = []
    for detection in msg.detections:
        header = detection.header if detection.header.frame_id else msg.header
        best = max(detection.results, key=lambda result: result.hypothesis.score, default=None)
        if best is None:
            if detection.id:
                tracks.append(track(detection.id, header, detection.bbox.center))
            continue
        object_id = detection.id or best.hypothesis.class_id
        tracks.append(track(object_id, header, best.pose.pose, float(best.hypothesis.score)))
    return tracks


def transforms_of_tf(
    msg: Any, *, is_static: bool
) -> tuple[list[StampedTransform], list[TrackFault]]:
    """Transforms of a tf2_msgs/TFMessage, and a fault for each that is none."""
    transforms, faults = [], []
    for item in msg.transforms:
        try:
            transform = StampedTransform(
                parent_frame=item.header.frame_id.lstrip('/'),
                child_frame=item.child_frame_id.lstrip('/'),
                stamp_ns=stamp_ns_from_msg(item.header.stamp),
                parent_from_child=pose_from_transform_msg(item.transform),
                is_static=is_static,
            )
        except SpatialRelationsError as error:
            faults.append(TrackFault(item.child_frame_id, str(error)))
        else:
            transforms.append(transform)
    return transforms, faults
