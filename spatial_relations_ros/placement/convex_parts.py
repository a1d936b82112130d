"""Cutting a solid into nearly convex parts, as physics engines want them."""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import open3d as o3d
from manifold3d import Manifold, Mesh
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError, TriangleMesh
from spatial_relations_ros.placement.ray_casting import as_tensor, ray_casting_scene

FloatArray = NDArray[np.float64]

MAX_PARTS = 320
_TOLERATED_PROTRUSION = 0.001
_LEAST_VOLUME = 1e-9
_LEAST_THICKNESS = 0.002
_NUM_VERTEX_CUTS = 4
# Cuts beside a vertex leave no sliver on the larger part.
_BESIDE = 2e-5
# Where on a triangle of a hull its distance to the solid is measured.
_BARYCENTRIC = np.array(
    [[1, 1, 1], [2, 2, 0], [2, 0, 2], [0, 2, 2], [4, 1, 1], [1, 4, 1], [1, 1, 4]], dtype=float
)
_BARYCENTRIC /= _BARYCENTRIC.sum(axis=1, keepdims=True)
_ANGLES = np.arange(4) * (np.pi / 4.0)
_NORMALS = np.concatenate(
    [
        [[0.0, 0.0, 1.0]],
        np.stack([np.cos(_ANGLES), np.sin(_ANGLES), np.zeros(4)], axis=1),
    ]
)


@dataclass(frozen=True, eq=False)
class ConvexPart:
    """A part of a solid, given by its convex hull.

    Attributes:
        points: (V, 3) float64; their hull is the part, in the solid's frame, metres.
        filled: share of the hull that belongs to the solid.
    """

    points: FloatArray
    filled: float


def convex_parts(mesh: TriangleMesh, *, max_parts: int = MAX_PARTS) -> tuple[ConvexPart, ...]:
    """Cuts a watertight mesh by planes until its parts are nearly convex.

    The part whose hull protrudes farthest from the solid is cut next, by the upright or level
    plane after which the hulls exceed the parts' volumes least. It ends when no hull protrudes by
    more than 1 mm, or at ``max_parts``.

    Raises:
        ConfigError: for a mesh that is not watertight.
    """
    solid = Manifold(Mesh(mesh.vertices.astype(np.float32), mesh.triangles.astype(np.uint32)))
    if solid.is_empty() or solid.volume() <= 0.0:
        raise ConfigError('only a watertight mesh can be cut into convex parts')
    surface = ray_casting_scene(mesh)
    waiting = [(-_protrusion(solid, surface), 0, solid)]
    finished: list[Manifold] = []
    number = 1
    while waiting and len(waiting) + len(finished) < max_parts:
        protrusion, _, part = heapq.heappop(waiting)
        pieces = _best_cut(part) if -protrusion > _TOLERATED_PROTRUSION else []
        if not pieces:
            finished.append(part)
        for piece in pieces:
            heapq.heappush(waiting, (-_protrusion(piece, surface), number, piece))
            number += 1
    return tuple(_part(piece) for piece in [*finished, *(entry[2] for entry in waiting)])


def _part(solid: Manifold) -> ConvexPart:
    hull = solid.hull()
    points = np.asarray(hull.to_mesh().vert_properties, dtype=np.float64)[:, :3]
    return ConvexPart(points, float(np.clip(solid.volume() / hull.volume(), 1e-3, 1.0)))


def _protrusion(part: Manifold, surface: o3d.t.geometry.RaycastingScene) -> float:
    """How far the hull of a part reaches out of the whole solid, metres."""
    hull = part.hull().to_mesh()
    corners = np.asarray(hull.vert_properties, dtype=np.float64)[:, :3][np.asarray(hull.tri_verts)]
    points = np.einsum('kc,tcd->tkd', _BARYCENTRIC, corners).reshape(-1, 3)
    return float(surface.compute_signed_distance(as_tensor(points)).numpy().max())


def _excess(solid: Manifold) -> float:
    return float(solid.hull().volume() - solid.volume())


def _best_cut(solid: Manifold) -> list[Manifold]:
    """Pieces after the best cut; none when nothing can be cut off."""
    vertices = np.asarray(solid.to_mesh().vert_properties, dtype=np.float64)[:, :3]
    best: list[Manifold] = []
    least = np.inf
    for normal in _NORMALS:
        for offset in _offsets(vertices @ normal):
            pieces = [
                piece
                for half in solid.split_by_plane(tuple(normal), offset)
                for piece in half.decompose()
                if piece.volume() > _LEAST_VOLUME
            ]
            cost = sum(_excess(piece) for piece in pieces)
            if len(pieces) > 1 and cost < least:
                best, least = pieces, cost
    return best


def _offsets(along: FloatArray) -> Iterator[float]:
    """Where to cut: in the middle, and at some of the vertices' places."""
    low, high = float(along.min()), float(along.max())
    if high - low < 2.0 * _LEAST_THICKNESS:
        return
    yield 0.5 * (low + high)
    _, first = np.unique(along.round(4), return_index=True)
    places = along[first]
    places = places[(places > low + _LEAST_THICKNESS / 2) & (places < high - _LEAST_THICKNESS / 2)]
    if len(places):
        count = min(_NUM_VERTEX_CUTS, len(places))
        for place in places[np.linspace(0, len(places) - 1, count).astype(np.int64)]:
            yield float(place) - _BESIDE
            yield float(place) + _BESIDE
