"""Core types to messages, and scenes back.

What trackers and cameras send is read by ``perception``, which bags share.
"""

from __future__ import annotations

import array
import dataclasses
import sys
from collections.abc import Sequence

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Pose as PoseMsg
from geometry_msgs.msg import PoseStamped
from numpy.typing import NDArray
from sensor_msgs.msg import PointCloud2, PointField
from spatial_relations_msgs.msg import Scene as SceneMsg
from spatial_relations_msgs.msg import SceneObject as SceneObjectMsg
from std_msgs.msg import Header

from spatial_relations_ros.core import (
    CloudSource,
    InvalidSceneError,
    Pose,
    Scene,
    SceneObject,
)
from spatial_relations_ros.core.rotations import xyzw_from_wxyz
from spatial_relations_ros.perception.frames import clean_frame_id
from spatial_relations_ros.perception.messages import read_pose, stamp_ns
from spatial_relations_ros.perception.point_cloud2 import read_xyz
from spatial_relations_ros.perception.series import NS_PER_SEC

XYZ_POINT_STEP = 12


def stamp_to_msg(time_ns: int) -> Time:
    """builtin_interfaces/Time of nanoseconds."""
    sec, nanosec = divmod(int(time_ns), NS_PER_SEC)
    return Time(sec=sec, nanosec=nanosec)


def header_to_msg(time_ns: int, frame_id: str) -> Header:
    """std_msgs/Header of a time in nanoseconds and a frame."""
    return Header(stamp=stamp_to_msg(time_ns), frame_id=frame_id)


def pose_to_msg(pose: Pose) -> PoseMsg:
    """geometry_msgs/Pose of a pose."""
    msg = PoseMsg()
    msg.position.x, msg.position.y, msg.position.z = pose.translation.tolist()
    quat_xyzw = xyzw_from_wxyz(pose.quat_wxyz).tolist()
    orientation = msg.orientation
    orientation.x, orientation.y, orientation.z, orientation.w = quat_xyzw
    return msg


def pose_stamped(pose: Pose, header: Header) -> PoseStamped:
    """geometry_msgs/PoseStamped of a pose in the header's frame."""
    return PoseStamped(header=header, pose=pose_to_msg(pose))


def cloud_to_msg(points: NDArray[np.float32], header: Header) -> PointCloud2:
    """An unorganised PointCloud2 of points (N, 3), fields x y z float32, packed."""
    points = np.ascontiguousarray(points, dtype='<f4' if sys.byteorder == 'little' else '>f4')
    fields = [
        PointField(name=name, offset=4 * idx, datatype=PointField.FLOAT32, count=1)
        for idx, name in enumerate('xyz')
    ]
    return PointCloud2(
        header=header,
        height=1,
        width=len(points),
        fields=fields,
        is_bigendian=sys.byteorder == 'big',
        point_step=XYZ_POINT_STEP,
        row_step=XYZ_POINT_STEP * len(points),
        # array.array is taken as it is; a numpy array would be checked byte by byte.
        data=array.array('B', points.tobytes()),
        is_dense=True,
    )


def scene_object_to_msg(scene_object: SceneObject, header: Header) -> SceneObjectMsg:
    """SceneObject.msg; the cloud's frame is the object itself."""
    cloud_header = Header(stamp=header.stamp, frame_id=scene_object.object_id)
    return SceneObjectMsg(
        object_id=scene_object.object_id,
        pose=pose_to_msg(scene_object.world_from_object),
        cloud=cloud_to_msg(scene_object.points, cloud_header),
        source=int(scene_object.source),
        support=float(scene_object.support),
    )


def scene_object_from_msg(msg: SceneObjectMsg) -> SceneObject:
    """The object of a SceneObject.msg.

    Raises:
        CloudFormatError: when the cloud cannot be read.
        InvalidPoseError: when the pose is none.
        InvalidSceneError: for an empty id, too few finite points or an unknown source.
    """
    try:
        source = CloudSource(msg.source)
    except ValueError as error:
        raise InvalidSceneError(
            f'{msg.object_id}: source is {msg.source}, expected 0 (MODEL) or 1 (OBSERVED)'
        ) from error
    return SceneObject(
        object_id=msg.object_id,
        points=read_xyz(msg.cloud).points,
        world_from_object=read_pose(msg.pose),
        source=source,
        support=float(msg.support),
    )


def scene_to_msg(scene: Scene) -> SceneMsg:
    """Scene.msg of a scene."""
    header = header_to_msg(scene.stamp_ns, scene.frame_id)
    return SceneMsg(
        header=header,
        base=scene_object_to_msg(scene.base, header),
        relative=scene_object_to_msg(scene.relative, header),
    )


def scene_from_msg(msg: SceneMsg) -> Scene:
    """The scene of a Scene.msg; raises as ``scene_object_from_msg`` does."""
    return Scene(
        base=scene_object_from_msg(msg.base),
        relative=scene_object_from_msg(msg.relative),
        stamp_ns=stamp_ns(msg.header.stamp),
        frame_id=msg.header.frame_id or 'world',
    )


def one_scene(scenes: Sequence[SceneMsg], field: str, *, world_frame: str) -> Scene | None:
    """The scene of a request field that holds at most one.

    Args:
        scenes: of the field.
        field: its name, for errors.
        world_frame: the frame in which it must be; a scene that names none is taken to be.

    Raises:
        InvalidSceneError: when there are several, or the one is not usable or in another frame.
    """
    if not scenes:
        return None
    if len(scenes) > 1:
        raise InvalidSceneError(f'{field} has {len(scenes)} scenes, at most one can be given')
    scene = scene_from_msg(scenes[0])
    given_frame = clean_frame_id(scenes[0].header.frame_id) or clean_frame_id(world_frame)
    if given_frame != clean_frame_id(world_frame):
        raise InvalidSceneError(
            f'{field}: the scene is in frame {given_frame!r}, expected the world frame '
            f'{world_frame!r}: transform its poses, or set the parameter world_frame'
        )
    return dataclasses.replace(scene, frame_id=world_frame)
