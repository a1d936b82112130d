"""What is drawn of an object: triangles with a normal at each corner.

A mesh is drawn as it is, smooth across shallow edges and sharp across steep ones. A cloud is
drawn as beads, a small ball a point: that needs no normals, which thin walls make unreliable, and
one ray caster serves both.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from spatial_relations_ros.core import SceneObject, TriangleMesh

CREASE_ANGLE_RAD = math.radians(38.0)
MAX_BEADS = 8_000
# Beads of this many median spacings nearly touch, so that a surface reads as one.
BEAD_RADIUS_SPACINGS = 0.95
GOLDEN_RATIO = (1.0 + math.sqrt(5.0)) / 2.0
# The icosahedron: corners of unit length and faces, counter-clockwise from outside.
BALL_CORNERS = np.array(
    [
        [-1, GOLDEN_RATIO, 0], [1, GOLDEN_RATIO, 0], [-1, -GOLDEN_RATIO, 0],
        [1, -GOLDEN_RATIO, 0], [0, -1, GOLDEN_RATIO], [0, 1, GOLDEN_RATIO],
        [0, -1, -GOLDEN_RATIO], [0, 1, -GOLDEN_RATIO], [GOLDEN_RATIO, 0, -1],
        [GOLDEN_RATIO, 0, 1], [-GOLDEN_RATIO, 0, -1], [-GOLDEN_RATIO, 0, 1],
    ]
) / math.hypot(1.0, GOLDEN_RATIO)  # fmt: skip
BALL_FACES = np.array(
    [
        [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11],
        [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
        [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9],
        [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1],
    ]
)  # fmt: skip
WELD_DIGITS = 6


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles in the world frame.

    Attributes:
        vertices: (V, 3) float32, metres.
        triangles: (T, 3) uint32.
        corner_normals: (T, 3, 3) float32 unit normals, one at each corner of each triangle.
        thickness: how far, in metres, the drawn surface may lie from the real one; rays that
            leave it start that far away.
    """

    vertices: NDArray[np.float32]
    triangles: NDArray[np.uint32]
    corner_normals: NDArray[np.float32]
    thickness: float


def surface_of(scene_object: SceneObject) -> Surface:
    """The object as it is drawn, in the world frame: its mesh, or else its cloud."""
    if scene_object.mesh is not None:
        return _mesh_surface(scene_object.mesh.transformed(scene_object.world_from_object))
    return _cloud_surface(scene_object.world_points)


def _mesh_surface(mesh: TriangleMesh) -> Surface:
    extent = float(np.ptp(mesh.vertices, axis=0).max())
    return Surface(
        mesh.vertices,
        mesh.triangles.astype(np.uint32),
        smooth_corner_normals(mesh.vertices, mesh.triangles),
        thickness=1e-4 * max(extent, 1e-3),
    )


def smooth_corner_normals(
    vertices: NDArray[np.float32], triangles: NDArray[np.int32]
) -> NDArray[np.float32]:
    """Normals (T, 3, 3) that are smooth over shallow edges and keep creases.

    A corner's normal is the area-weighted mean over the triangles that meet in its place and are
    inclined to its own triangle by less than the crease angle.
    """
    corners = vertices[triangles].astype(np.float64)
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(areas, axis=1, keepdims=True)
    units = areas / np.maximum(lengths, 1e-30)
    # Meshes from files repeat a vertex for every triangle: weld by place.
    places = np.unique(np.round(vertices, WELD_DIGITS), axis=0, return_inverse=True)[1]
    corner_places = places.reshape(-1)[triangles].reshape(-1)
    order = np.argsort(corner_places, kind='stable')
    sorted_places = corner_places[order]
    starts = np.flatnonzero(np.r_[True, sorted_places[1:] != sorted_places[:-1]])
    counts = np.diff(np.r_[starts, len(sorted_places)])
    # Every ordered pair of corners in one place.
    repeats = np.repeat(counts, counts)
    first = np.repeat(np.arange(len(order)), repeats)
    offsets = np.arange(len(first)) - np.repeat(np.cumsum(repeats) - repeats, repeats)
    second = np.repeat(np.repeat(starts, counts), repeats) + offsets
    own, other = order[first] // 3, order[second] // 3
    shallow = (units[own] * units[other]).sum(axis=1) > math.cos(CREASE_ANGLE_RAD)
    sums = np.zeros((len(order), 3))
    for axis in range(3):
        weights = np.where(shallow, areas[other, axis], 0.0)
        sums[:, axis] = np.bincount(order[first], weights=weights, minlength=len(order))
    norms = np.linalg.norm(sums, axis=1, keepdims=True)
    flat = np.repeat(units, 3, axis=0)
    normals = np.where(norms > 1e-20, sums / np.maximum(norms, 1e-30), flat)
    return normals.reshape(-1, 3, 3).astype(np.float32)


def _cloud_surface(points: NDArray[np.float32]) -> Surface:
    if len(points) > MAX_BEADS:
        points = points[:: math.ceil(len(points) / MAX_BEADS)]
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points.astype(np.float64)))
    spacing = float(np.median(np.asarray(cloud.compute_nearest_neighbor_distance())))
    radius = BEAD_RADIUS_SPACINGS * max(spacing, 1e-5)
    vertices = points[:, None] + (radius * BALL_CORNERS).astype(np.float32)
    faces = np.arange(len(points))[:, None, None] * len(BALL_CORNERS) + BALL_FACES
    normals = np.broadcast_to(
        BALL_CORNERS[BALL_FACES].astype(np.float32), (len(points), *BALL_FACES.shape, 3)
    )
    return Surface(
        vertices.reshape(-1, 3),
        faces.reshape(-1, 3).astype(np.uint32),
        normals.reshape(-1, 3, 3),
        thickness=0.3 * radius,
    )
