"""Transforms of /tf and /tf_static, for nodes that ask for a few frames."""

from __future__ import annotations

from tf2_msgs.msg import TFMessage

from spatial_relations_ros.core import FrameTransformError, Pose
from spatial_relations_ros.perception.frames import TransformBuffer, TransformBufferConfig
from spatial_relations_ros.perception.messages import read_transforms
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.relations_node import RelationsNode

_LATEST_NS = 2**62
# Arms may rest, and then their frames come seldom: the nearest sample holds for ever.
_FOR_EVER_SEC = 1e10


class TransformListener:
    """Remembers transforms."""

    def __init__(self, node: RelationsNode) -> None:
        """Subscribes on ``node``."""
        self._node = node
        self._buffer = TransformBuffer(TransformBufferConfig(max_extrapolation_sec=_FOR_EVER_SEC))
        node.subscribe(
            TFMessage, '/tf', lambda msg: self._add(msg, is_static=False), qos.TRANSFORMS
        )
        node.subscribe(
            TFMessage,
            '/tf_static',
            lambda msg: self._add(msg, is_static=True),
            qos.STATIC_TRANSFORMS,
        )

    def _add(self, msg: TFMessage, *, is_static: bool) -> None:
        transforms, _ = read_transforms(msg, is_static=is_static)
        for transform in transforms:
            try:
                self._buffer.add(transform)
            except FrameTransformError as error:
                self._node.report_bad('/tf', error)

    def world_from(self, world_frame: str, frame: str, stamp_ns: int) -> Pose:
        """The pose of a frame in the world at a time, or the latest one when that is 0.

        Raises:
            FrameTransformError: when the frame is not known or not connected with the world.
        """
        return self._buffer.lookup(world_frame, frame, stamp_ns or _LATEST_NS)
