"""Records bags without ROS: mcap with the definitions of its messages, compressed."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import (
    Connection,
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.rosbag2.errors import WriterError

from spatial_relations_ros.core import BagError, Pose
from spatial_relations_ros.core.rotations import xyzw_from_wxyz
from spatial_relations_ros.evaluation.bag_types import (
    POINT_CLOUD,
    POSE_STAMPED,
    TF_MESSAGE,
    TRACKED_OBJECTS,
    package_typestore,
)
from spatial_relations_ros.perception.border import StampedTransform, TrackedPose
from spatial_relations_ros.perception.series import NS_PER_SEC

FLOAT32 = 7
# iai_kinect2 pads its points as PCL does: x y z at 0, 4, 8 and rgb at 16 of 32 bytes.
KINECT2_POINT_STEP = 32
KINECT2_RGB_OFFSET = 16
_FOREVER = QosTime(9223372036, 854775807)  # RMW_DURATION_INFINITE


class BagWriter:
    """Writes one bag; use it in a ``with`` block.

    Args:
        path: the folder to be made.
        storage: mcap (compressed) or sqlite3.

    Raises:
        BagError: when the folder exists already or cannot be made.
        ConfigError: when the definitions of the own messages are not there.
    """

    def __init__(self, path: Path | str, *, storage: StoragePlugin = StoragePlugin.MCAP) -> None:
        self.types = package_typestore()
        self._connections: dict[str, Connection] = {}
        try:
            self._writer = Writer(Path(path), version=9, storage_plugin=storage)
        except WriterError as error:
            raise BagError(str(error)) from error
        if storage == StoragePlugin.MCAP:
            self._writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)

    def __enter__(self) -> BagWriter:
        try:
            self._writer.open()
        except (WriterError, OSError) as error:
            raise BagError(f'the bag cannot be made: {error}') from error
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._writer.__exit__(exc_type, exc_value, traceback)

    def write(self, topic: str, time_ns: int, message: Any) -> None:
        """Writes a message of any type that ``types`` knows.

        Args:
            topic: its topic.
            time_ns: when it was received.
            message: made by the classes of ``types``.
        """
        msgtype = message.__msgtype__
        if topic not in self._connections:
            self._connections[topic] = self._writer.add_connection(
                topic,
                msgtype,
                typestore=self.types,
                offered_qos_profiles=[_qos(latched=topic == '/tf_static')],
            )
        data = self.types.serialize_cdr(message, msgtype)
        self._writer.write(self._connections[topic], time_ns, data)

    def cloud(
        self,
        stamp_ns: int,
        frame_id: str,
        xyz: NDArray[np.float32],
        rgb: NDArray[np.uint8],
    ) -> Any:
        """An organised PointCloud2 as iai_kinect2 lays it out.

        Args:
            stamp_ns: time of measurement.
            frame_id: an optical frame.
            xyz: (H, W, 3) metres; NaN where nothing was measured.
            rgb: (H, W, 3) uint8.
        """
        height, width = xyz.shape[:2]
        points = np.zeros((height, width, KINECT2_POINT_STEP), dtype=np.uint8)
        points[..., :12] = xyz.astype('<f4').view(np.uint8)
        red, green, blue = np.moveaxis(rgb.astype('<u4'), -1, 0)
        packed = red << 16 | green << 8 | blue
        colours = packed[..., None].view(np.uint8)
        points[..., KINECT2_RGB_OFFSET : KINECT2_RGB_OFFSET + 4] = colours
        field = self.types.types['sensor_msgs/msg/PointField']
        offsets = {'x': 0, 'y': 4, 'z': 8, 'rgb': KINECT2_RGB_OFFSET}
        return self.types.types[POINT_CLOUD](
            header=self._header(stamp_ns, frame_id),
            height=height,
            width=width,
            fields=[field(name, offset, FLOAT32, 1) for name, offset in offsets.items()],
            is_bigendian=False,
            point_step=KINECT2_POINT_STEP,
            row_step=KINECT2_POINT_STEP * width,
            data=points.reshape(-1),
            is_dense=False,
        )

    def pose_stamped(self, track: TrackedPose) -> Any:
        """A ``geometry_msgs/PoseStamped``."""
        return self.types.types[POSE_STAMPED](
            header=self._header(track.stamp_ns, track.frame_id),
            pose=self._pose(track.frame_from_object),
        )

    def tracked_objects(self, stamp_ns: int, frame_id: str, tracks: list[TrackedPose]) -> Any:
        """A ``spatial_relations_msgs/TrackedObjectArray``."""
        item = self.types.types['spatial_relations_msgs/msg/TrackedObject']
        return self.types.types[TRACKED_OBJECTS](
            header=self._header(stamp_ns, frame_id),
            objects=[
                item(
                    header=self._header(track.stamp_ns, track.frame_id),
                    object_id=track.object_id,
                    pose=self._pose(track.frame_from_object),
                    confidence=track.confidence,
                )
                for track in tracks
            ],
        )

    def transforms(self, transforms: list[StampedTransform]) -> Any:
        """A ``tf2_msgs/TFMessage``."""
        types = self.types.types
        return types[TF_MESSAGE](
            transforms=[
                types['geometry_msgs/msg/TransformStamped'](
                    header=self._header(item.stamp_ns, item.parent_frame),
                    child_frame_id=item.child_frame,
                    transform=types['geometry_msgs/msg/Transform'](
                        translation=types['geometry_msgs/msg/Vector3'](
                            *item.parent_from_child.translation.tolist()
                        ),
                        rotation=self._quaternion(item.parent_from_child),
                    ),
                )
                for item in transforms
            ]
        )

    def _header(self, stamp_ns: int, frame_id: str) -> Any:
        types = self.types.types
        stamp = types['builtin_interfaces/msg/Time'](*divmod(stamp_ns, NS_PER_SEC))
        return types['std_msgs/msg/Header'](stamp=stamp, frame_id=frame_id)

    def _pose(self, pose: Pose) -> Any:
        types = self.types.types
        return types['geometry_msgs/msg/Pose'](
            position=types['geometry_msgs/msg/Point'](*pose.translation.tolist()),
            orientation=self._quaternion(pose),
        )

    def _quaternion(self, pose: Pose) -> Any:
        quat_xyzw = xyzw_from_wxyz(pose.quat_wxyz).tolist()
        return self.types.types['geometry_msgs/msg/Quaternion'](*quat_xyzw)


def _qos(*, latched: bool) -> Qos:
    """Reliable; what is latched reaches those who come late."""
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=100 if latched else 10,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
        deadline=_FOREVER,
        lifespan=_FOREVER,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=_FOREVER,
        avoid_ros_namespace_conventions=False,
    )
