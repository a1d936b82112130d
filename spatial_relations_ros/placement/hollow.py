"""The room that an object encloses but for an opening, found by ray casting."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from spatial_relations_ros.core import TriangleMesh

FloatArray = NDArray[np.float64]

_NUM_CANDIDATES = 6000
_NUM_DIRECTIONS = 96
_NUM_AROUND = 24
_LEAST_COVER = 0.6
_LEAST_AROUND = 0.9
_LEAST_SHARE = 0.04
_SLACK = 2e-3


@dataclass(frozen=True, eq=False)
class Hollow:
    """An object's hollow, object frame.

    Attributes:
        opening: (3,) unit vector out of the opening.
        depth: from the deepest point of the hollow to the rim along the opening, metres.
        width: its least extent across the opening, metres.
        rim: how far along ``opening`` (from the object's origin) the hollow reaches, metres.
        share: of the convex hull's volume that the hollow takes.
    """

    opening: FloatArray
    depth: float
    width: float
    rim: float
    share: float

    def encloses(
        self, rays: o3d.t.geometry.RaycastingScene, points: FloatArray
    ) -> NDArray[np.bool_]:
        """Which points (P, 3) between bottom and rim have the object all around them."""
        along = points @ self.opening
        candidates = (along < self.rim + _SLACK) & (along > self.rim - self.depth - _SLACK)
        enclosed = np.zeros(len(points), dtype=bool)
        if candidates.any():
            enclosed[candidates] = _is_surrounded(rays, points[candidates], self.opening)
        return enclosed


def find_hollow(
    rays: o3d.t.geometry.RaycastingScene,
    mesh: TriangleMesh,
    hull_equations: FloatArray,
    *,
    num_candidates: int = _NUM_CANDIDATES,
) -> Hollow | None:
    """Looks for points within the convex hull that are free, yet covered from most sides.

    Args:
        rays: ray casting on the mesh.
        mesh: watertight.
        hull_equations: (F, 4) of its convex hull, negative inside.
        num_candidates: points to look at; time grows with them.
    """
    vertices = mesh.vertices.astype(np.float64)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    rng = np.random.default_rng(0)
    points = rng.uniform(low, high, (num_candidates, 3))
    points = points[(points @ hull_equations[:, :3].T + hull_equations[:, 3]).max(axis=1) < 0.0]
    num_in_hull = len(points)
    tensor = o3d.core.Tensor.from_numpy(points.astype(np.float32))
    points = points[rays.compute_occupancy(tensor, nsamples=3).numpy() < 0.5]
    if len(points) < _LEAST_SHARE * num_in_hull:
        return None
    directions = _sphere(_NUM_DIRECTIONS)
    hits = _hits(rays, points, directions)
    covered = hits.mean(axis=1) > _LEAST_COVER
    if covered.sum() < _LEAST_SHARE * num_in_hull:
        return None
    free = (~hits[covered]).astype(np.float64)
    if not free.any():
        return None  # closed all around
    outwards = free.sum(axis=0) @ directions
    if np.linalg.norm(outwards) < 0.2 * free.sum():
        # Open on both sides, as a ring is: the axis is where most free rays lead.
        moments = (directions * free.sum(axis=0)[:, None]).T @ directions
        outwards = np.linalg.eigh(moments)[1][:, -1]
    opening = _snapped(outwards / np.linalg.norm(outwards), rays, points)
    inside = points[_is_surrounded(rays, points, opening)]
    if len(inside) < _LEAST_SHARE * num_in_hull:
        return None
    along = inside @ opening
    rim = float(np.quantile(along, 0.995))
    return Hollow(
        opening,
        depth=rim - float(np.quantile(along, 0.005)),
        width=float(np.ptp(inside @ _around(opening).T, axis=0).min()),
        rim=rim,
        share=len(inside) / num_in_hull,
    )


def _snapped(
    direction: FloatArray, rays: o3d.t.geometry.RaycastingScene, points: FloatArray
) -> FloatArray:
    """The axis of the frame near a direction, where it surrounds no fewer points."""
    axis = np.zeros(3)
    strongest = int(np.argmax(np.abs(direction)))
    axis[strongest] = np.sign(direction[strongest])
    if abs(direction[strongest]) < np.cos(np.deg2rad(25.0)):
        return direction
    found = [_is_surrounded(rays, points, candidate).sum() for candidate in (axis, direction)]
    return axis if found[0] >= 0.95 * found[1] else direction


def _is_surrounded(
    rays: o3d.t.geometry.RaycastingScene, points: FloatArray, axis: FloatArray
) -> NDArray[np.bool_]:
    return np.asarray(_hits(rays, points, _around(axis)).mean(axis=1) >= _LEAST_AROUND)


def _around(axis: FloatArray) -> FloatArray:
    """Unit vectors (24, 3) normal to an axis (3,)."""
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    angles = np.arange(_NUM_AROUND) * (2.0 * np.pi / _NUM_AROUND) + 0.05
    return np.outer(np.cos(angles), first) + np.outer(np.sin(angles), second)


def _hits(
    rays: o3d.t.geometry.RaycastingScene, points: FloatArray, directions: FloatArray
) -> NDArray[np.bool_]:
    """Whether rays from points (P, 3) along directions (D, 3) meet the object, (P, D)."""
    packed = np.empty((len(points), len(directions), 6), dtype=np.float32)
    packed[..., :3] = points[:, None]
    packed[..., 3:] = directions
    distances = rays.cast_rays(o3d.core.Tensor.from_numpy(packed))['t_hit'].numpy()
    return np.asarray(np.isfinite(distances))


def _sphere(count: int) -> FloatArray:
    """Directions (count, 3) spread evenly: a Fibonacci lattice."""
    idx = np.arange(count) + 0.5
    z = 1.0 - 2.0 * idx / count
    angle = np.pi * (1.0 + 5.0**0.5) * idx
    radius = np.sqrt(1.0 - z * z)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)
