"""Draws markers as RViz would, without a display: for documentation and tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import open3d as o3d
from visualization_msgs.msg import Marker

from spatial_relations_ros.core import ConfigError, Pose, SceneObject, TriangleMesh
from spatial_relations_ros.perception.messages import read_pose
from spatial_relations_ros.visualization import Camera, Image, frame_objects, render_scene
from spatial_relations_ros.visualization.lettering import letter
from spatial_relations_ros.visualization.palette import Rgb

ARROW_FACETS = 24


@dataclass(frozen=True, eq=False)
class _Drawn:
    """A marker as an object."""

    item: SceneObject
    color: Rgb
    is_ghost: bool


def draw_markers(
    markers: Sequence[Marker], *, width: int = 960, height: int = 640, camera: Camera | None = None
) -> Image:
    """A picture of points, triangles, arrows and texts; translucent markers are drawn as ghosts.

    Args:
        markers: of one or several arrays; what deletes is left out, and so are other types.
        width: pixels, when no camera is given.
        height: pixels, when no camera is given.
        camera: where from; one that frames everything by default.

    Returns:
        (height, width, 3) uint8 RGB.

    Raises:
        ConfigError: when nothing can be drawn.
    """
    drawn = [found for marker in markers if (found := _drawn(marker)) is not None]
    if not drawn:
        raise ConfigError('there is no marker to draw')
    solid = [found for found in drawn if not found.is_ghost]
    ghosts = [found for found in drawn if found.is_ghost]
    if camera is None:
        camera = frame_objects([[found.item for found in drawn]], width=width, height=height)
    picture = render_scene(
        [found.item for found in solid],
        ghosts=[found.item for found in ghosts],
        camera=camera,
        colours=[found.color for found in solid],
        ghost_colours=[found.color for found in ghosts],
    )
    for marker in markers:
        if marker.action == Marker.ADD and marker.type == Marker.TEXT_VIEW_FACING:
            _letter(picture, camera, marker)
    return picture


def _drawn(marker: Marker) -> _Drawn | None:
    if marker.action != Marker.ADD:
        return None
    points = np.array([[point.x, point.y, point.z] for point in marker.points], dtype=np.float32)
    color = (float(marker.color.r), float(marker.color.g), float(marker.color.b))
    pose, mesh = read_pose(marker.pose), None
    if marker.type == Marker.TRIANGLE_LIST:
        mesh = TriangleMesh(points, np.arange(len(points), dtype=np.int32).reshape(-1, 3))
    elif marker.type == Marker.ARROW and len(points) == 2:
        mesh = _arrow(points, marker)
        points = mesh.vertices
    elif marker.type != Marker.POINTS:
        return None
    item = SceneObject(f'{marker.ns}/{marker.id}', points, pose, mesh=mesh)
    return _Drawn(item, color, marker.color.a < 1.0)


def _arrow(ends: np.ndarray, marker: Marker) -> TriangleMesh:
    """An arrow from the first point to the second."""
    way = ends[1] - ends[0]
    length = max(float(np.linalg.norm(way)), 1e-6)
    head = min(marker.scale.z or 0.25 * length, 0.9 * length)
    arrow = o3d.geometry.TriangleMesh.create_arrow(
        cylinder_radius=marker.scale.x / 2.0, cone_radius=marker.scale.y / 2.0,
        cylinder_height=length - head, cone_height=head, resolution=ARROW_FACETS,
    )  # fmt: skip
    forward = way / length
    side = np.cross(forward, np.eye(3)[np.argmin(np.abs(forward))])
    side /= np.linalg.norm(side)
    rotation = np.stack([side, np.cross(forward, side), forward], axis=1)
    placed = Pose.from_rotation(rotation, ends[0].astype(float)).apply(np.asarray(arrow.vertices))
    return TriangleMesh(placed.astype(np.float32), np.asarray(arrow.triangles, dtype=np.int32))


def _letter(picture: Image, camera: Camera, marker: Marker) -> None:
    position = read_pose(marker.pose).translation
    pixel, depth = camera.project(position)
    if depth <= 0.0:
        return
    size = max(11, round(0.6 * float(marker.scale.z) * camera.focal_length / float(depth)))
    place = (float(pixel[0]), float(pixel[1]))
    letter(picture, marker.text, place, size=size, bold=True, anchor='mm')
