"""Triangle meshes, as plain arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core.errors import InvalidSceneError
from spatial_relations_ros.core.pose import Pose


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """A triangle mesh in its object's frame.

    Attributes:
        vertices: (V, 3) float32, metres.
        triangles: (T, 3) int32 vertex indices, counter-clockwise seen from outside.

    Raises:
        InvalidSceneError: for wrong shapes, non-finite vertices or indices out of range.
    """

    vertices: NDArray[np.float32]
    triangles: NDArray[np.int32]

    def __post_init__(self) -> None:
        vertices = np.ascontiguousarray(self.vertices, dtype=np.float32)
        triangles = np.ascontiguousarray(self.triangles, dtype=np.int32)
        if vertices.ndim != 2 or vertices.shape[1] != 3 or len(vertices) < 3:
            raise InvalidSceneError(f'a mesh needs vertices (V >= 3, 3), got {vertices.shape}')
        if triangles.ndim != 2 or triangles.shape[1] != 3 or len(triangles) < 1:
            raise InvalidSceneError(f'a mesh needs triangles (T >= 1, 3), got {triangles.shape}')
        if not np.isfinite(vertices).all():
            raise InvalidSceneError('mesh has vertices that are not finite')
        if triangles.min() < 0 or triangles.max() >= len(vertices):
            raise InvalidSceneError(
                f'triangles index vertices {triangles.min()} to {triangles.max()}, '
                f'the mesh has {len(vertices)}'
            )
        object.__setattr__(self, 'vertices', vertices)
        object.__setattr__(self, 'triangles', triangles)

    def transformed(self, target_from_mesh: Pose) -> TriangleMesh:
        """The same mesh in another frame."""
        return TriangleMesh(
            target_from_mesh.apply(self.vertices).astype(np.float32), self.triangles
        )

    def sample_surface(self, num_points: int, rng: np.random.Generator) -> NDArray[np.float32]:
        """Points (num_points, 3) spread uniformly over the surface."""
        corners = self.vertices[self.triangles].astype(np.float64)
        edges_1, edges_2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        areas = np.linalg.norm(np.cross(edges_1, edges_2), axis=1)
        cumulative = np.cumsum(areas)
        if cumulative[-1] <= 0.0:
            raise InvalidSceneError('mesh has no surface area')
        # Stratified along the cumulated area: more even than independent draws.
        picks = (np.arange(num_points) + rng.random(num_points)) * (cumulative[-1] / num_points)
        triangle_idx = np.minimum(np.searchsorted(cumulative, picks), len(areas) - 1)
        root = np.sqrt(rng.random(num_points))[:, None]
        along = rng.random(num_points)[:, None]
        points: NDArray[np.float64] = (
            corners[triangle_idx, 0]
            + root * (1.0 - along) * edges_1[triangle_idx]
            + root * along * edges_2[triangle_idx]
        )
        return points.astype(np.float32)
