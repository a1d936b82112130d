"""Objects and targets as markers for RViz."""

from __future__ import annotations

import colorsys
import zlib
from collections.abc import Iterable

import numpy as np
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from spatial_relations_ros.core import SceneObject
from spatial_relations_ros.ros.conversions import pose_to_msg

MAX_POINTS = 1500
POINT_SIZE = 0.004
TEXT_SIZE = 0.03


def color_of(object_id: str, alpha: float) -> ColorRGBA:
    """A colour that is the same for an id in every run."""
    hue = zlib.crc32(object_id.encode()) % 360 / 360.0
    red, green, blue = colorsys.hsv_to_rgb(hue, 0.65, 0.95)
    return ColorRGBA(r=red, g=green, b=blue, a=alpha)


def object_markers(
    objects: Iterable[SceneObject], header: Header, *, namespace: str, alpha: float = 1.0
) -> MarkerArray:
    """A cloud and a name for each object; whatever was in the namespace before goes away."""
    array = MarkerArray()
    for part in ('cloud', 'name'):
        array.markers.append(
            Marker(header=header, ns=f'{namespace}/{part}', action=Marker.DELETEALL)
        )
    for idx, scene_object in enumerate(objects):
        points = scene_object.points[:: max(1, len(scene_object.points) // MAX_POINTS)]
        cloud = Marker(
            header=header,
            ns=f'{namespace}/cloud',
            id=idx,
            type=Marker.POINTS,
            action=Marker.ADD,
            pose=pose_to_msg(scene_object.world_from_object),
            color=color_of(scene_object.object_id, alpha),
            points=[Point(x=x, y=y, z=z) for x, y, z in points.tolist()],
        )
        cloud.scale.x = cloud.scale.y = POINT_SIZE
        name = Marker(
            header=header,
            ns=f'{namespace}/name',
            id=idx,
            type=Marker.TEXT_VIEW_FACING,
            action=Marker.ADD,
            text=scene_object.object_id,
            color=ColorRGBA(r=1.0, g=1.0, b=1.0, a=alpha),
        )
        top = scene_object.world_points.max(axis=0)
        middle = np.median(scene_object.world_points, axis=0)
        position = name.pose.position
        position.x, position.y = float(middle[0]), float(middle[1])
        position.z = float(top[2]) + TEXT_SIZE
        name.scale.z = TEXT_SIZE
        array.markers += [cloud, name]
    return array
