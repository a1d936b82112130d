"""The orientations in which an object stands on a table."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from spatial_relations_ros.core import TriangleMesh

FloatArray = NDArray[np.float64]

_LEVEL_COSINE = np.cos(np.deg2rad(8.0))
_SAME_PLANE_COSINE = np.cos(np.deg2rad(1.0))


class RestKind(enum.Enum):
    """Which way an object's z axis points when it rests."""

    UPRIGHT = 'upright'
    UPSIDE_DOWN = 'upside down'
    SIDE = 'side'


@dataclass(frozen=True, eq=False)
class RestPose:
    """A stable orientation.

    Attributes:
        rotation: (3, 3), world_from_object.
        kind: which way up.
        margin: distance of the projected centre of mass from the footprint's border, metres.
        centre_height: of the centre of mass above the table, metres.
    """

    rotation: FloatArray
    kind: RestKind
    margin: float
    centre_height: float

    @property
    def tipping_angle_rad(self) -> float:
        """The smallest tilt of the table at which the object falls over."""
        return float(np.arctan2(self.margin, self.centre_height))


def rotation_between(source: FloatArray, target: FloatArray) -> FloatArray:
    """Smallest rotation (3, 3) that turns one unit vector (3,) into another."""
    cosine = float(source @ target)
    if cosine < -1.0 + 1e-9:
        helper = np.eye(3)[int(np.argmin(np.abs(source)))]
        axis = np.cross(source, helper)
        axis /= np.linalg.norm(axis)
        return 2.0 * np.outer(axis, axis) - np.eye(3)
    cross = np.cross(source, target)
    skew = np.array([[0, -cross[2], cross[1]], [cross[2], 0, -cross[0]], [-cross[1], cross[0], 0]])
    rotation: FloatArray = np.eye(3) + skew + skew @ skew / (1.0 + cosine)
    return rotation


def find_rest_poses(
    mesh: TriangleMesh, centre_of_mass: FloatArray, *, min_margin: float = 5e-4
) -> tuple[RestPose, ...]:
    """Stable orientations: faces of the convex hull above which the centre of mass lies.

    Sorted by margin, widest first.
    """
    hull = ConvexHull(mesh.vertices.astype(np.float64))
    normals, groups = _merge_facets(hull)
    poses = []
    for normal, simplices in zip(normals, groups, strict=True):
        rotation = rotation_between(normal, np.array([0.0, 0.0, -1.0]))
        footprint = hull.points[np.unique(hull.simplices[simplices])] @ rotation.T
        centre = rotation @ centre_of_mass
        margin = footprint_margin(footprint[:, :2], centre[:2])
        if margin > min_margin:
            height = float(centre[2] - footprint[:, 2].min())
            poses.append(RestPose(rotation, _kind(rotation), margin, height))
    return tuple(sorted(poses, key=lambda pose: -pose.margin))


def footprint_margin(footprint: FloatArray, point: FloatArray) -> float:
    """Distance of a point (2,) from the border of the hull of points (N, 2); negative outside."""
    if (point < footprint.min(axis=0)).any() or (point > footprint.max(axis=0)).any():
        return -np.inf
    try:
        hull = ConvexHull(footprint)
    except QhullError:  # a line or a point: nothing stands on it
        return -np.inf
    return float(-(hull.equations[:, :2] @ point + hull.equations[:, 2]).max())


def _merge_facets(hull: ConvexHull) -> tuple[list[FloatArray], list[NDArray[np.intp]]]:
    normals, groups = [], []
    remaining = np.arange(len(hull.equations))
    while len(remaining):
        normal = hull.equations[remaining[0], :3]
        offset = hull.equations[remaining[0], 3]
        same = hull.equations[remaining, :3] @ normal > _SAME_PLANE_COSINE
        same &= np.abs(hull.equations[remaining, 3] - offset) < 1e-3
        normals.append(normal)
        groups.append(remaining[same])
        remaining = remaining[~same]
    return normals, groups


def _kind(rotation: FloatArray) -> RestKind:
    if rotation[2, 2] > _LEVEL_COSINE:
        return RestKind.UPRIGHT
    if rotation[2, 2] < -_LEVEL_COSINE:
        return RestKind.UPSIDE_DOWN
    return RestKind.SIDE
