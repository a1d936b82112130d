"""Rays against the surfaces of a picture; Embree on the CPU, through Open3D."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from spatial_relations_ros.visualization.surfaces import Surface

FloatArray = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Hits:
    """The first surface on each of R rays.

    Attributes:
        surface_idx: (R,) int64, -1 where nothing is hit.
        distance: (R,) in units of the ray's direction; infinite where nothing is hit.
        normal: (R, 3) unit, towards the ray's origin; zero where nothing is hit.
    """

    surface_idx: NDArray[np.int64]
    distance: FloatArray
    normal: FloatArray


class RayCaster:
    """Casts rays at several surfaces."""

    def __init__(self, surfaces: Sequence[Surface]) -> None:
        self._scene = o3d.t.geometry.RaycastingScene()
        self._first_triangle = np.zeros(len(surfaces) + 1, dtype=np.int64)
        for surface_idx, surface in enumerate(surfaces):
            self._scene.add_triangles(_tensor(surface.vertices), _tensor(surface.triangles))
            self._first_triangle[surface_idx + 1] = self._first_triangle[surface_idx] + len(
                surface.triangles
            )
        self._num_surfaces = len(surfaces)
        empty = np.zeros((0, 3, 3), dtype=np.float32)
        self._corner_normals = np.concatenate(
            [empty, *(surface.corner_normals for surface in surfaces)]
        )
        self._thickness = np.array(
            [surface.thickness for surface in surfaces] or [0.0], dtype=np.float32
        )

    def first_hits(self, origin: NDArray[np.floating], directions: FloatArray) -> Hits:
        """What rays from one origin (3,) in directions (R, 3) meet first."""
        num_rays = len(directions)
        if num_rays == 0 or self._num_surfaces == 0:
            return Hits(
                np.full(num_rays, -1),
                np.full(num_rays, np.inf, dtype=np.float32),
                np.zeros((num_rays, 3), dtype=np.float32),
            )
        rays = np.empty((num_rays, 6), dtype=np.float32)
        rays[:, :3] = origin
        rays[:, 3:] = directions
        answer = self._scene.cast_rays(_tensor(rays))
        surface_idx = answer['geometry_ids'].numpy().astype(np.int64)
        missed = surface_idx == int(self._scene.INVALID_ID)
        surface_idx[missed] = -1
        return Hits(
            surface_idx,
            answer['t_hit'].numpy(),
            self._normals(
                surface_idx,
                answer['primitive_ids'].numpy(),
                answer['primitive_uvs'].numpy(),
                directions,
            ),
        )

    def _normals(
        self,
        surface_idx: NDArray[np.int64],
        primitive_idx: NDArray[np.uint32],
        uv: FloatArray,
        directions: FloatArray,
    ) -> FloatArray:
        """Corner normals interpolated at the hits, turned towards the rays' origin."""
        hit = surface_idx >= 0
        normals = np.zeros((len(surface_idx), 3), dtype=np.float32)
        corners = self._corner_normals[
            self._first_triangle[surface_idx[hit]] + primitive_idx[hit].astype(np.int64)
        ]
        u, v = uv[hit, :1], uv[hit, 1:]
        blend = corners[:, 0] * (1.0 - u - v) + corners[:, 1] * u + corners[:, 2] * v
        blend /= np.maximum(np.linalg.norm(blend, axis=1, keepdims=True), 1e-12)
        away = np.einsum('rc,rc->r', blend, directions[hit]) > 0.0
        blend[away] *= -1.0
        normals[hit] = blend
        return normals

    def thickness(self, surface_idx: NDArray[np.int64]) -> FloatArray:
        """How far from each hit (R,) a ray that leaves it has to start, metres."""
        thickness: FloatArray = self._thickness[surface_idx]
        return thickness

    def visibility(
        self, origins: FloatArray, directions: NDArray[np.floating], reach: float = np.inf
    ) -> FloatArray:
        """The share of directions in which nothing is met within ``reach``.

        Args:
            origins: (R, 3).
            directions: (L, 3) the same for all origins, or (R, L, 3).
            reach: in units of the directions' length.

        Returns:
            (R,) 0 to 1.
        """
        directions = np.asarray(directions, dtype=np.float32)
        num_directions = directions.shape[-2]
        visible = np.ones(len(origins), dtype=np.float32)
        if len(origins) == 0 or self._num_surfaces == 0:
            return visible
        rays = np.empty((len(origins), 6), dtype=np.float32)
        rays[:, :3] = origins
        tensor = _tensor(rays)  # shares the memory of ``rays``
        for direction_idx in range(num_directions):
            rays[:, 3:] = directions[..., direction_idx, :]
            blocked = self._scene.test_occlusions(tensor, 0.0, float(reach)).numpy()
            visible -= blocked * np.float32(1.0 / num_directions)
        return np.clip(visible, 0.0, 1.0)


def _tensor(values: NDArray[np.float32] | NDArray[np.uint32]) -> o3d.core.Tensor:
    """Open3D's view of an array; both use the same memory."""
    return o3d.core.Tensor.from_numpy(np.ascontiguousarray(values))
