"""Objects as markers for RViz."""

from __future__ import annotations

import colorsys
import zlib
from collections.abc import Iterable
from weakref import WeakKeyDictionary

import numpy as np
from geometry_msgs.msg import Point, Pose
from numpy.typing import NDArray
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from spatial_relations_ros.core import SceneObject, TriangleMesh
from spatial_relations_ros.ros.conversions import pose_to_msg
from spatial_relations_ros.visualization.palette import Rgb
from spatial_relations_ros.visualization.simplification import simplified_mesh

MAX_POINTS = 1500
MAX_TRIANGLES = 1500
POINT_SIZE = 0.004
TEXT_SIZE = 0.03
TEXT_COLOR: Rgb = (1.0, 1.0, 1.0)


def color_of(object_id: str, alpha: float) -> ColorRGBA:
    """A colour that is the same for an id in every run."""
    hue = zlib.crc32(object_id.encode()) % 360 / 360.0
    red, green, blue = colorsys.hsv_to_rgb(hue, 0.65, 0.95)
    return ColorRGBA(r=red, g=green, b=blue, a=alpha)


def color_to_msg(color: Rgb, alpha: float = 1.0) -> ColorRGBA:
    """ColorRGBA of a colour, 0 to 1 a channel."""
    red, green, blue = color
    return ColorRGBA(r=red, g=green, b=blue, a=alpha)


def delete_all(header: Header) -> Marker:
    """Clears the display; RViz clears all namespaces, so it comes first in an array and once."""
    return Marker(header=header, action=Marker.DELETEALL)


def object_markers(
    objects: Iterable[SceneObject], header: Header, *, namespace: str, alpha: float = 1.0
) -> MarkerArray:
    """A cloud and a name for each object; whatever the display showed before goes away."""
    array = MarkerArray(markers=[delete_all(header)])
    for idx, item in enumerate(objects):
        color = color_of(item.object_id, alpha)
        array.markers += [
            cloud_marker(item, header, color, namespace=f'{namespace}/cloud', idx=idx),
            name_marker(item, header, item.object_id, namespace=f'{namespace}/name', idx=idx),
        ]
    return array


def cloud_marker(
    item: SceneObject, header: Header, color: ColorRGBA, *, namespace: str, idx: int
) -> Marker:
    """The object's cloud, at most so many points."""
    points = item.points[:: -(-len(item.points) // MAX_POINTS)]
    marker = _marker(Marker.POINTS, header, namespace, idx, color)
    marker.pose = pose_to_msg(item.world_from_object)
    marker.points = [Point(x=x, y=y, z=z) for x, y, z in points.tolist()]
    marker.scale.x = marker.scale.y = POINT_SIZE
    return marker


def shape_marker(
    item: SceneObject, header: Header, color: ColorRGBA, *, namespace: str, idx: int
) -> Marker:
    """The object's mesh, simplified, where it has one; otherwise its cloud."""
    if item.mesh is None:
        return cloud_marker(item, header, color, namespace=namespace, idx=idx)
    if item.mesh not in _corners:
        mesh = simplified_mesh(item.mesh, MAX_TRIANGLES)
        _corners[item.mesh] = mesh.vertices[mesh.triangles].reshape(-1, 3)
    marker = _marker(Marker.TRIANGLE_LIST, header, namespace, idx, color)
    marker.pose = pose_to_msg(item.world_from_object)
    marker.points = [Point(x=x, y=y, z=z) for x, y, z in _corners[item.mesh].tolist()]
    marker.scale.x = marker.scale.y = marker.scale.z = 1.0
    return marker


_corners: WeakKeyDictionary[TriangleMesh, NDArray[np.float32]] = WeakKeyDictionary()


def name_marker(
    item: SceneObject, header: Header, text: str, *, namespace: str, idx: int
) -> Marker:
    """A text above the object."""
    top = item.world_points.max(axis=0)
    middle = np.median(item.world_points, axis=0)
    position = (float(middle[0]), float(middle[1]), float(top[2]) + TEXT_SIZE)
    return text_marker(position, header, text, namespace=namespace, idx=idx)


def text_marker(
    position: tuple[float, float, float], header: Header, text: str, *, namespace: str, idx: int
) -> Marker:
    """A text that faces the viewer, white as RViz's ground is dark."""
    marker = _marker(Marker.TEXT_VIEW_FACING, header, namespace, idx, color_to_msg(TEXT_COLOR))
    marker.text = text
    x, y, z = position
    marker.pose = Pose(position=Point(x=x, y=y, z=z))
    marker.scale.z = TEXT_SIZE
    return marker


def _marker(kind: int, header: Header, namespace: str, idx: int, color: ColorRGBA) -> Marker:
    return Marker(header=header, ns=namespace, id=idx, type=kind, action=Marker.ADD, color=color)
