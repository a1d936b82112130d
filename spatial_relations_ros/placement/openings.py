"""The opening of a container, measured on its mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import open3d as o3d
from scipy.spatial import ConvexHull, QhullError

from spatial_relations_ros.core import TriangleMesh
from spatial_relations_ros.placement.body import FloatArray
from spatial_relations_ros.placement.hollow import find_hollow
from spatial_relations_ros.placement.model import Opening
from spatial_relations_ros.placement.ray_casting import as_tensor, ray_casting_scene
from spatial_relations_ros.placement.rest_poses import rotation_between
from spatial_relations_ros.placement.resting import about_z

_NUM_CANDIDATES = 2000
_NUM_AROUND = 32
_NUM_YAWS = 18
_BELOW_RIM = 0.06
_ABOVE_FLOOR = 0.12
# Share of its bounding rectangle that a clear section fills: a disc 0.79, a rectangle 1.
_ROUND_BELOW = 0.9


@dataclass(frozen=True, eq=False)
class FoundOpening:
    """An opening and the frame in which it opens towards +z.

    Attributes:
        rotation: (3, 3) that turns the mesh's frame into the opening's, about the same origin.
        opening: in that frame.
    """

    rotation: FloatArray
    opening: Opening


def find_opening(mesh: TriangleMesh) -> FoundOpening | None:
    """Where something could be put into a solid; None for one without a hollow.

    A rectangular opening has its sides along x and y of the frame. The clear widths are those
    just below the rim and just above the floor.

    Args:
        mesh: watertight, metres.
    """
    rays = ray_casting_scene(mesh)
    try:
        hull = ConvexHull(mesh.vertices.astype(np.float64))
    except QhullError:
        return None
    hollow = find_hollow(rays, mesh, hull.equations, num_candidates=_NUM_CANDIDATES)
    if hollow is None:
        return None
    upright = rotation_between(hollow.opening, np.array([0.0, 0.0, 1.0]))
    rim_z, floor_z = hollow.rim, hollow.rim - hollow.depth
    rim_level = rim_z - _BELOW_RIM * hollow.depth
    vertices = mesh.vertices.astype(np.float64) @ upright.T
    start = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))[:2]
    rim = _section(rays, upright, start, rim_level)
    if rim is None:
        return None
    yaw = _tightest_yaw(rim)
    rotation = about_z(-yaw) @ upright
    rim = rim @ about_z(-yaw)[:2, :2].T
    centre = 0.5 * (rim.min(axis=0) + rim.max(axis=0))
    half_size = 0.5 * np.ptp(rim, axis=0)
    floor = _section(rays, rotation, centre, floor_z + _ABOVE_FLOOR * hollow.depth)
    floor_half = half_size if floor is None else np.minimum(0.5 * np.ptp(floor, axis=0), half_size)
    is_round = _area(rim) < _ROUND_BELOW * 4.0 * half_size[0] * half_size[1]
    return FoundOpening(
        rotation,
        Opening(
            (float(half_size[0]), float(half_size[1])),
            (float(floor_half[0]), float(floor_half[1])),
            float(rim_z),
            float(floor_z),
            bool(is_round),
            (float(centre[0]), float(centre[1])),
        ),
    )


def _section(
    rays: o3d.t.geometry.RaycastingScene, rotation: FloatArray, centre: FloatArray, height: float
) -> FloatArray | None:
    """Border (32, 2) of the clear room around a point at a height, in a turned frame."""
    angles = np.arange(_NUM_AROUND) * (2.0 * np.pi / _NUM_AROUND)
    directions = np.stack([np.cos(angles), np.sin(angles), np.zeros(_NUM_AROUND)], axis=1)
    border = np.zeros((_NUM_AROUND, 2))
    for _ in range(2):  # the second time from the middle of the room
        origin = np.array([*centre, height])
        packed = np.empty((_NUM_AROUND, 6))
        packed[:, :3] = origin @ rotation
        packed[:, 3:] = directions @ rotation
        travel = rays.cast_rays(as_tensor(packed))['t_hit'].numpy().astype(np.float64)
        if not np.isfinite(travel).mean() > 0.8:
            return None
        travel[~np.isfinite(travel)] = np.median(travel[np.isfinite(travel)])
        border = centre + travel[:, None] * directions[:, :2]
        centre = 0.5 * (border.min(axis=0) + border.max(axis=0))
    return border


def _tightest_yaw(border: FloatArray) -> float:
    """Angle, 0 to pi/2, of the smallest rectangle around a section."""
    yaws = np.arange(_NUM_YAWS) * (0.5 * np.pi / _NUM_YAWS)
    along = border @ np.stack([np.cos(yaws), np.sin(yaws)])
    across = border @ np.stack([-np.sin(yaws), np.cos(yaws)])
    areas = np.ptp(along, axis=0) * np.ptp(across, axis=0)
    return float(yaws[int(areas.argmin())])


def _area(border: FloatArray) -> float:
    following = np.roll(border, -1, axis=0)
    return 0.5 * abs(
        float((border[:, 0] * following[:, 1] - following[:, 0] * border[:, 1]).sum())
    )
