"""Contacts between two placed bodies: first contact, clearance, touching points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.placement.body import FloatArray, Placed
from spatial_relations_ros.placement.ray_casting import as_tensor

CONTACT_GAP = 0.0005
MAX_PENETRATION = 0.001
_NEAR = 0.01


@dataclass(frozen=True, eq=False)
class Contacts:
    """Places where two bodies touch.

    Attributes:
        points: (C, 3) world frame.
        normals: (C, 3) world frame, unit, pointing from the first body into the second.
    """

    points: FloatArray
    normals: FloatArray

    def __len__(self) -> int:
        return len(self.points)


def travel_to_contact(moving: Placed, fixed: Placed, direction: FloatArray) -> float:
    """How far a body can be shifted along a unit direction (3,) until it first touches another.

    Metres; infinite when it passes. The bodies must be apart at the start. Exact where a vertex
    or sampled edge point meets a face.
    """
    return first_contact(moving, fixed, direction)[0]


def first_contact(
    moving: Placed, fixed: Placed, direction: FloatArray
) -> tuple[float, FloatArray]:
    """The distance of ``travel_to_contact``, and where it touches (3,) after the shift."""
    forwards, source = _first_hit(moving, fixed, direction)
    backwards, met = _first_hit(fixed, moving, -direction)
    if forwards <= backwards:
        return forwards, source + forwards * direction if np.isfinite(forwards) else source
    return backwards, met


def _first_hit(source: Placed, target: Placed, direction: FloatArray) -> tuple[float, FloatArray]:
    """Shortest ray from the source's points to the target, and the point it starts at."""
    origins = target.to_object(source.world_points)
    local_direction = target.rotation.T @ direction
    picked = np.flatnonzero(_may_hit(origins, local_direction, target))
    if not len(picked):
        return np.inf, np.zeros(3)
    rays = np.empty((len(picked), 6), dtype=np.float32)
    rays[:, :3] = origins[picked]
    rays[:, 3:] = local_direction
    hits = target.body.surface.cast_rays(as_tensor(rays))['t_hit'].numpy()
    nearest = int(hits.argmin())
    return float(hits[nearest]), source.world_points[picked[nearest]]


def _may_hit(
    origins: NDArray[np.float32], direction: FloatArray, target: Placed
) -> NDArray[np.bool_]:
    """Which rays cross the target's bounding box (slab test), object frame."""
    half = target.body.model.half_extents + 1e-4
    steps = np.where(np.abs(direction) < 1e-7, 1e-7, direction)
    ends = np.sign(steps) * half
    # Axis by axis: several times faster than a reduction over rows of three.
    near = (-ends[0] - origins[:, 0]) / steps[0]
    far = (ends[0] - origins[:, 0]) / steps[0]
    for axis in (1, 2):
        np.maximum(near, (-ends[axis] - origins[:, axis]) / steps[axis], out=near)
        np.minimum(far, (ends[axis] - origins[:, axis]) / steps[axis], out=far)
    return np.asarray((near <= far) & (far >= 0.0))


def clearance(first: Placed, second: Placed) -> float:
    """Smallest signed distance of either body's points to the other; negative in penetration."""
    return min(_clearance(first, second), _clearance(second, first))


def is_clear(first: Placed, second: Placed, gap: float) -> bool:
    """Whether :func:`clearance` is at least a gap >= 0, metres; faster where bodies are apart."""
    for source, target in ((first, second), (second, first)):
        near = source.world_points[_is_near(source, target, gap)]
        if len(near) and float(signed_distance(target, near).min()) < gap:
            return False
    return True


def _clearance(source: Placed, target: Placed) -> float:
    points = source.world_points
    near = points[_is_near(source, target, _NEAR)]
    if len(near):
        nearest = float(signed_distance(target, near).min())
        if nearest < _NEAR:
            return nearest
    return float(signed_distance(target, points).min())


def _is_near(source: Placed, target: Placed, gap: float) -> NDArray[np.bool_]:
    """Which points of the source are within the target's bounding box, widened by a gap."""
    apart = np.abs(target.to_object(source.world_points))
    reach = target.body.model.half_extents + gap
    return np.asarray(
        (apart[:, 0] < reach[0]) & (apart[:, 1] < reach[1]) & (apart[:, 2] < reach[2])
    )


def signed_distance(target: Placed, points: FloatArray) -> NDArray[np.float32]:
    """Signed distances (P,) of world points to a body's surface, metres, negative inside."""
    distances: NDArray[np.float32] = target.body.surface.compute_signed_distance(
        as_tensor(target.to_object(points))
    ).numpy()
    return distances


def find_contacts(first: Placed, second: Placed, *, gap: float = CONTACT_GAP) -> Contacts:
    """Points where two bodies are closer than ``gap`` metres, with the contact's normal.

    The normal is that of a face: of the other body where an edge or vertex touches it, of both
    where two faces lie on each other.
    """
    points_1, normals_1 = _touching(second, first, gap)
    points_2, normals_2 = _touching(first, second, gap)
    return Contacts(np.concatenate([points_1, points_2]), np.concatenate([normals_1, -normals_2]))


def _touching(source: Placed, target: Placed, gap: float) -> tuple[FloatArray, FloatArray]:
    """Points of ``source`` on ``target`` and the target's outward normals there."""
    near = np.flatnonzero(_is_near(source, target, gap))
    points, normals = source.world_points[near], source.world_normals()[near]
    is_feature = near < source.body.num_features
    if not len(points):
        return np.zeros((0, 3)), np.zeros((0, 3))
    query = target.to_object(points)
    closest = target.body.surface.compute_closest_points(as_tensor(query))
    distance = np.linalg.norm(closest['points'].numpy() - query, axis=1)
    face_normals = closest['primitive_normals'].numpy() @ target.rotation.T
    facing = -np.einsum('ij,ij->i', face_normals, normals)
    # Faces touch only when they are parallel; an edge's normal is a mean of its faces.
    kept = (distance < gap) & (facing > np.where(is_feature, 0.35, 0.97))
    return points[kept], face_normals[kept]


def table_contacts(placed: Placed, *, gap: float = CONTACT_GAP) -> Contacts:
    """Points of a body that stand on the table z = 0; normals point up, into the body."""
    points = placed.world_vertices
    points = points[points[:, 2] < gap]
    return Contacts(points, np.tile([0.0, 0.0, 1.0], (len(points), 1)))
