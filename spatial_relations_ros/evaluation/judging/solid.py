"""What the judge measures once on each mesh: samples, mass centre, ways to rest, hollow."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import open3d as o3d
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from spatial_relations_ros.core import InvalidSceneError, TriangleMesh
from spatial_relations_ros.placement.hollow import Hollow, find_hollow

FloatArray = NDArray[np.float64]

_NUM_SURFACE_POINTS = 6000
_EDGE_SPACING = 0.002
_SHARP_COSINE = np.cos(np.deg2rad(20.0))
_REST_MARGIN = 3e-4
_FOOT_BAND = 1e-4
_KEPT_SOLIDS = 256


@dataclass(frozen=True, eq=False)
class Solid:
    """A mesh with what the judge needs of it; all in the mesh's own frame.

    Attributes:
        mesh: watertight.
        rays: Open3D's ray casting on it.
        surface_points: (N, 3) evenly over the surface, denser along its sharp edges.
        centre_of_mass: (3,) of the material, metres.
        rest_directions: (R, 3) unit vectors that point down when it stands on level ground.
    """

    mesh: TriangleMesh
    rays: o3d.t.geometry.RaycastingScene
    surface_points: FloatArray
    centre_of_mass: FloatArray
    rest_directions: FloatArray

    @cached_property
    def hull_equations(self) -> FloatArray:
        """(F, 4) of the convex hull: inside where ``points @ e[:3] + e[3] <= 0``."""
        equations: FloatArray = ConvexHull(self.mesh.vertices.astype(np.float64)).equations
        return equations

    @cached_property
    def hollow(self) -> Hollow | None:
        """The room that the object encloses but for an opening; None where there is none."""
        return find_hollow(self.rays, self.mesh, self.hull_equations)

    def signed_distance(self, points: FloatArray) -> FloatArray:
        """Distance (P,) of points (P, 3) to the surface, metres, negative inside."""
        packed = np.ascontiguousarray(points, dtype=np.float32)
        distances = self.rays.compute_signed_distance(o3d.core.Tensor.from_numpy(packed)).numpy()
        # One ray gives the sign, and may slip between two triangles: more rays vote then.
        inside = np.flatnonzero(distances < 0.0)
        if len(inside):
            again = o3d.core.Tensor.from_numpy(packed[inside])
            distances[inside] = self.rays.compute_signed_distance(again, nsamples=11).numpy()
        return np.asarray(distances, dtype=np.float64)


@lru_cache(maxsize=_KEPT_SOLIDS)
def solid_of(mesh: TriangleMesh) -> Solid:
    """The solid of a mesh, kept for later scenes of the same object.

    Raises:
        InvalidSceneError: for a mesh that is flat.
    """
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        o3d.core.Tensor.from_numpy(mesh.vertices),
        o3d.core.Tensor.from_numpy(mesh.triangles.astype(np.uint32)),
    )
    samples = mesh.sample_surface(_NUM_SURFACE_POINTS, np.random.default_rng(0))
    points = np.concatenate([samples.astype(np.float64), _edge_points(mesh)])
    centre = _centre_of_mass(mesh)
    return Solid(mesh, scene, points, centre, _rest_directions(mesh, centre))


def _edge_points(mesh: TriangleMesh) -> FloatArray:
    """Points along edges at which the surface turns by more than 20 degrees."""
    corners = mesh.vertices[mesh.triangles].astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-15)
    # Vertices are merged by place: files may repeat them for each triangle.
    _, place = np.unique(mesh.vertices.round(6), axis=0, return_inverse=True)
    triangles = place.reshape(-1)[mesh.triangles]
    edges = np.sort(
        np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1
    )
    owner = np.tile(np.arange(len(triangles)), 3)
    order = np.lexsort(edges.T)
    edges, owner = edges[order], owner[order]
    is_pair = (edges[1:] == edges[:-1]).all(axis=1)
    first, second = owner[:-1][is_pair], owner[1:][is_pair]
    is_sharp = np.einsum('ei,ei->e', normals[first], normals[second]) < _SHARP_COSINE
    vertex_of_place = np.zeros(int(place.max()) + 1, dtype=np.int64)
    vertex_of_place[place.reshape(-1)] = np.arange(len(mesh.vertices))
    ends = mesh.vertices[vertex_of_place[edges[:-1][is_pair][is_sharp]]].astype(np.float64)
    if not len(ends):
        return mesh.vertices.astype(np.float64)
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    counts = np.maximum(np.ceil(lengths / _EDGE_SPACING).astype(np.int64), 1)
    row = np.repeat(np.arange(len(ends)), counts)
    step = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = (step / counts[row])[:, None]
    return np.concatenate(
        [ends[row, 0] * (1.0 - share) + ends[row, 1] * share, mesh.vertices.astype(np.float64)]
    )


def _centre_of_mass(mesh: TriangleMesh) -> FloatArray:
    """Of the enclosed volume, by the divergence theorem over tetrahedra to the first vertex."""
    corners = mesh.vertices.astype(np.float64)[mesh.triangles]
    origin = corners[0, 0]
    a, b, c = (corners[:, idx] - origin for idx in range(3))
    volumes = np.einsum('ti,ti->t', a, np.cross(b, c)) / 6.0
    total = float(volumes.sum())
    if abs(total) < 1e-12:
        raise InvalidSceneError('the mesh encloses no volume')
    centre: FloatArray = origin + (volumes @ (a + b + c)) / (4.0 * total)
    return centre


def _rest_directions(mesh: TriangleMesh, centre: FloatArray) -> FloatArray:
    """Normals of those faces of the convex hull on which the object can stand."""
    vertices = mesh.vertices.astype(np.float64)
    try:
        hull = ConvexHull(vertices)
    except QhullError as error:
        raise InvalidSceneError('the mesh is flat') from error
    directions = []
    for equation in np.unique(hull.equations.round(4), axis=0):
        normal = equation[:3] / np.linalg.norm(equation[:3])
        height = vertices @ normal
        foot = vertices[height > height.max() - _FOOT_BAND]
        # The centre of mass stands over the foot when no direction separates them.
        helper = np.eye(3)[int(np.argmin(np.abs(normal)))]
        axes = np.stack([np.cross(normal, helper), np.cross(normal, np.cross(normal, helper))])
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        angles = np.arange(72) * (np.pi / 36.0)
        around = np.stack([np.cos(angles), np.sin(angles)], axis=1) @ axes
        margins = (foot @ around.T).max(axis=0) - around @ centre
        if margins.min() > _REST_MARGIN:
            directions.append(normal)
    return np.array(directions).reshape(-1, 3)
