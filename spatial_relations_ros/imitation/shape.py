"""Solid shapes: signed distances of objects, exact for meshes and estimated for clouds."""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import weakref

import numpy as np
import open3d as o3d
import torch
from manifold3d import Manifold
from numpy.typing import NDArray

from spatial_relations_ros.core import InvalidSceneError, SceneObject, TriangleMesh
from spatial_relations_ros.datasets.objects.solids import mesh_of
from spatial_relations_ros.datasets.solidify import is_watertight, solid_from_cloud
from spatial_relations_ros.imitation.distance_field import DistanceField

CONTACT_POINTS = 2048
_GRID_CELLS = 40
_MARGIN_CELLS = 3
_LEAST_SPACING = 1e-4
_GRAZING_DEPTH = 7e-4
_MAX_VERTICES = 1024
_KEPT_CLOUDS = 32
_LEAST_THICKNESS = 1e-4
_LEAST_SHARE = 0.01

Array = NDArray[np.float32]


class Shape:
    """The solid that an object is, in its own frame.

    With a watertight mesh everything is exact. With a cloud alone it is an estimate
    (:func:`~spatial_relations_ros.datasets.solidify.solid_from_cloud`); of a cloud that has too
    few points for that, its convex hull.

    Attributes:
        mesh: the solid's surface, watertight.
        points: (2048, 3) surface points.
        field: signed distance on a grid, differentiable.
        centre_of_mass: (3,), of the solid's volume.
        edges: (E, 2, 3) edges of the mesh; none for a cloud.
        is_estimate: whether the solid comes from a cloud.
    """

    def __init__(self, item: SceneObject) -> None:
        mesh = item.mesh if item.mesh is not None and is_watertight(item.mesh) else None
        self.is_estimate = mesh is None
        self.mesh = _estimated(item.points) if mesh is None else mesh
        self.points = _contact_points(self.mesh)
        self.edges = np.zeros((0, 2, 3), np.float32) if self.is_estimate else _edges(self.mesh)
        self.centre_of_mass = _volume_centroid(self.mesh)
        self._caster = o3d.t.geometry.RaycastingScene()
        self._caster.add_triangles(
            o3d.core.Tensor.from_numpy(self.mesh.vertices),
            o3d.core.Tensor.from_numpy(self.mesh.triangles.astype(np.uint32)),
        )
        self.field = self._distance_field()

    def signed_distance(self, points: Array) -> Array:
        """Metres from points (N, 3) in the object frame to the surface, negative inside."""
        queries = o3d.core.Tensor.from_numpy(np.ascontiguousarray(points, dtype=np.float32))
        return np.asarray(self._caster.compute_signed_distance(queries).numpy())

    def ray_travel(self, origins: Array, directions: Array) -> Array:
        """Metres along rays (N, 3) in the object frame to the first hit; inf without one."""
        rays = np.concatenate([origins, directions], axis=1).astype(np.float32)
        return np.asarray(
            self._caster.cast_rays(o3d.core.Tensor.from_numpy(rays))['t_hit'].numpy()
        )

    def passes(self, segments: Array) -> NDArray[np.bool_]:
        """Which segments (N, 2, 3) in the object frame pass all through a wall of the solid.

        A segment that only grazes the surface does not: half way between entering and leaving
        it must be 0.7 mm below the surface, so walls thinner than twice that are not seen.
        """
        offsets = segments[:, 1] - segments[:, 0]
        rays = np.concatenate([segments[:, 0], offsets], axis=1).astype(np.float32)
        hits = self._caster.list_intersections(o3d.core.Tensor.from_numpy(rays))
        along, ray = hits['t_hit'].numpy(), hits['ray_ids'].numpy().astype(int)
        within = (along > 0.0) & (along < 1.0)
        along, ray = along[within], ray[within]
        order = np.lexsort((along, ray))
        along, ray = along[order], ray[order]
        counts = np.bincount(ray, minlength=len(segments))
        through = np.flatnonzero((counts > 0) & (counts % 2 == 0))
        first_hit = np.searchsorted(ray, through)
        middle = 0.5 * (along[first_hit] + along[first_hit + 1])[:, None]
        depths = self.signed_distance(segments[through, 0] + middle * offsets[through])
        passing = np.zeros(len(segments), dtype=bool)
        passing[through[depths < -_GRAZING_DEPTH]] = True
        return passing

    def _distance_field(self) -> DistanceField:
        spacing, origin, counts = _grid(self.points)
        nodes = _grid_nodes(spacing, origin, counts)
        values = self.signed_distance(nodes.reshape(-1, 3)).reshape(counts)
        return DistanceField(torch.from_numpy(values), torch.from_numpy(origin), spacing)


_shapes: weakref.WeakKeyDictionary[TriangleMesh, Shape] = weakref.WeakKeyDictionary()
_cloud_shapes: dict[bytes, Shape] = {}


def shape_of(item: SceneObject) -> Shape:
    """The shape of an object; made once for each mesh, and for each of the last clouds."""
    if item.mesh is None:
        key = hashlib.blake2b(np.ascontiguousarray(item.points).tobytes()).digest()
        shape = _cloud_shapes.pop(key, None) or Shape(item)
        _cloud_shapes[key] = shape
        while len(_cloud_shapes) > _KEPT_CLOUDS:
            del _cloud_shapes[next(iter(_cloud_shapes))]
        return shape
    if item.mesh not in _shapes:
        _shapes[item.mesh] = Shape(item)
    return _shapes[item.mesh]


def _estimated(points: Array) -> TriangleMesh:
    """The solid of a cloud (N, 3), or the hull of one that is too sparse or too flat."""
    with contextlib.suppress(InvalidSceneError):
        return solid_from_cloud(points)
    thickness = max(_LEAST_THICKNESS, _LEAST_SHARE * float(np.ptp(points, axis=0).max()))
    offsets = 0.5 * thickness * np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    corners = (points[:, None].astype(np.float64) + offsets).reshape(-1, 3)
    return mesh_of(Manifold.hull_points(corners))


def _contact_points(mesh: TriangleMesh) -> Array:
    """Surface points and, since solids touch at their corners first, vertices."""
    rng = np.random.default_rng(0)
    vertices = mesh.vertices
    if len(vertices) > _MAX_VERTICES:
        vertices = rng.choice(vertices, _MAX_VERTICES, replace=False)
    return np.concatenate([vertices, mesh.sample_surface(CONTACT_POINTS - len(vertices), rng)])


def _edges(mesh: TriangleMesh) -> Array:
    pairs = mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    return mesh.vertices[np.unique(np.sort(pairs, axis=1), axis=0)]


def _volume_centroid(mesh: TriangleMesh) -> Array:
    corners = mesh.vertices[mesh.triangles].astype(np.float64)
    volumes = np.einsum('ij,ij->i', corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    total = volumes.sum()
    if abs(total) < 1e-12:
        return np.asarray(mesh.vertices.mean(axis=0))
    centroid = (volumes[:, None] * corners.sum(axis=1)).sum(axis=0) / (4.0 * total)
    return np.asarray(centroid, dtype=np.float32)


def _grid(points: Array) -> tuple[float, Array, tuple[int, int, int]]:
    """Spacing, origin (3,) and node counts of a grid around points."""
    low, high = points.min(axis=0), points.max(axis=0)
    spacing = max(float((high - low).max()) / _GRID_CELLS, _LEAST_SPACING)
    origin = (low - _MARGIN_CELLS * spacing).astype(np.float32)
    cells = np.ceil((high - low) / spacing).astype(int) + 2 * _MARGIN_CELLS
    return spacing, origin, (int(cells[0]) + 1, int(cells[1]) + 1, int(cells[2]) + 1)


def _grid_nodes(spacing: float, origin: Array, counts: tuple[int, int, int]) -> Array:
    nodes = np.stack(np.meshgrid(*(np.arange(count) for count in counts), indexing='ij'), axis=-1)
    return (origin + spacing * nodes).astype(np.float32)
