"""Solid shapes: signed distances of objects, exact for meshes and estimated for clouds."""

from __future__ import annotations

import weakref

import numpy as np
import open3d as o3d
import torch
from numpy.typing import NDArray
from scipy import ndimage, spatial

from spatial_relations_ros.core import SceneObject, TriangleMesh
from spatial_relations_ros.imitation.distance_field import DistanceField
from spatial_relations_ros.projection import resample_points

CONTACT_POINTS = 2048
_GRID_CELLS = 40
_MARGIN_CELLS = 3
_GRAZING_DEPTH = 7e-4
_MAX_VERTICES = 1024

Array = NDArray[np.float32]


class Shape:
    """The solid that an object is, in its own frame.

    With a watertight mesh everything is exact. With a cloud alone it is an estimate on a grid of
    at most 40 cells: cells that hold points, and cells that cannot be reached from outside without
    crossing such cells, are solid; openings stay open.

    Attributes:
        points: (2048, 3) surface points.
        field: signed distance on a grid, differentiable.
        centre_of_mass: (3,), of the solid's volume (mesh) or of its surface points (cloud).
        mesh: the watertight mesh, where there is one.
        edges: (E, 2, 3) edges of the mesh; none for a cloud.
        is_estimate: whether the solid comes from a cloud.
    """

    def __init__(self, item: SceneObject) -> None:
        mesh = item.mesh if item.mesh is not None and _is_watertight(item.mesh) else None
        self.mesh = mesh
        self.is_estimate = mesh is None
        self._caster = o3d.t.geometry.RaycastingScene()
        if mesh is not None:
            self.points = _contact_points(mesh)
            self.edges = _edges(mesh)
            self.centre_of_mass = _volume_centroid(mesh)
            self._add_triangles(mesh.vertices, mesh.triangles)
            self.field = self._mesh_field()
        else:
            self.points = resample_points(item.points, CONTACT_POINTS)
            self.edges = np.zeros((0, 2, 3), dtype=np.float32)
            self.centre_of_mass = self.points.mean(axis=0)
            self.field, vertices, triangles = _cloud_solid(item.points)
            self._add_triangles(vertices, triangles)

    def signed_distance(self, points: Array) -> Array:
        """Metres from points (N, 3) in the object frame to the surface, negative inside."""
        if self.is_estimate:
            return np.asarray(self.field.sample(torch.from_numpy(points)).numpy())
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

    def _add_triangles(self, vertices: Array, triangles: NDArray[np.int32]) -> None:
        self._caster.add_triangles(
            o3d.core.Tensor.from_numpy(vertices),
            o3d.core.Tensor.from_numpy(triangles.astype(np.uint32)),
        )

    def _mesh_field(self) -> DistanceField:
        spacing, origin, counts = _grid(self.points)
        nodes = _grid_nodes(spacing, origin, counts)
        values = self.signed_distance(nodes.reshape(-1, 3)).reshape(counts)
        return DistanceField(torch.from_numpy(values), torch.from_numpy(origin), spacing)


_shapes: weakref.WeakKeyDictionary[TriangleMesh, Shape] = weakref.WeakKeyDictionary()


def shape_of(item: SceneObject) -> Shape:
    """The shape of an object; made once for each mesh, each time for a cloud."""
    if item.mesh is None:
        return Shape(item)
    if item.mesh not in _shapes:
        _shapes[item.mesh] = Shape(item)
    return _shapes[item.mesh]


def _is_watertight(mesh: TriangleMesh) -> bool:
    """Whether every edge is used once in each direction."""
    edges = mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).astype(np.int64)
    count = len(mesh.vertices)
    forward = np.sort(edges[:, 0] * count + edges[:, 1])
    backward = np.sort(edges[:, 1] * count + edges[:, 0])
    return bool(np.array_equal(forward, backward))


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


def _grid(points: Array, min_spacing: float = 1e-4) -> tuple[float, Array, tuple[int, int, int]]:
    """Spacing, origin (3,) and node counts of a grid around points."""
    low, high = points.min(axis=0), points.max(axis=0)
    spacing = max(float((high - low).max()) / _GRID_CELLS, min_spacing)
    origin = (low - _MARGIN_CELLS * spacing).astype(np.float32)
    cells = np.ceil((high - low) / spacing).astype(int) + 2 * _MARGIN_CELLS
    return spacing, origin, (int(cells[0]) + 1, int(cells[1]) + 1, int(cells[2]) + 1)


def _grid_nodes(spacing: float, origin: Array, counts: tuple[int, int, int]) -> Array:
    nodes = np.stack(np.meshgrid(*(np.arange(count) for count in counts), indexing='ij'), axis=-1)
    return (origin + spacing * nodes).astype(np.float32)


def _cloud_solid(points: Array) -> tuple[DistanceField, Array, NDArray[np.int32]]:
    """Signed distance and a mesh of cubes for the solid that a cloud seems to enclose."""
    # Cells must be wider than the gaps between points, or the solid leaks.
    neighbours = spatial.KDTree(points).query(points, k=2)[0][:, 1]
    min_spacing = max(2.0 * float(np.quantile(neighbours, 0.75)), 1e-4)
    spacing, origin, counts = _grid(points, min_spacing)
    occupied = np.zeros(counts, dtype=bool)
    cells = np.rint((points - origin) / spacing).astype(int)
    occupied[tuple(cells.T)] = True
    # Thickened by a cell the shell has no holes; what a flood from outside does not reach, less
    # that thickness again, is solid.
    cube = np.ones((3, 3, 3), dtype=bool)
    flooded = ~ndimage.binary_fill_holes(ndimage.binary_dilation(occupied, cube))
    solid = occupied | ~ndimage.binary_dilation(flooded, cube)
    outside = ndimage.distance_transform_edt(~solid)
    inside = ndimage.distance_transform_edt(solid)
    # The surface runs through the points, that is through the outermost solid cells.
    values = ((outside - inside + np.where(solid, 1.0, 0.0)) * spacing).astype(np.float32)
    field = DistanceField(torch.from_numpy(values), torch.from_numpy(origin), spacing)
    shell = np.argwhere(solid & (inside <= 1.0))
    centres = (origin + spacing * shell).astype(np.float32)
    vertices, triangles = _cubes(centres, 0.5 * spacing)
    return field, vertices, triangles


def _cubes(centres: Array, half_size: float) -> tuple[Array, NDArray[np.int32]]:
    """Vertices and triangles of axis-aligned cubes around centres (N, 3)."""
    corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1], indexing='ij')).reshape(3, 8).T
    quads = np.array(
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    )
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    vertices = centres[:, None, :] + half_size * corners[None]
    indices = triangles[None] + 8 * np.arange(len(centres))[:, None, None]
    return (
        vertices.reshape(-1, 3).astype(np.float32),
        indices.reshape(-1, 3).astype(np.int32),
    )
