"""Which pairs of objects can show a relation at all, by their shapes.

After the paper, only containment excludes pairs: the base must be a container and the relative
must go through its opening, as deep as the judge asks of what is inside.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.signal import fftconvolve
from scipy.spatial import ConvexHull

from spatial_relations_ros.core import Relation, TriangleMesh
from spatial_relations_ros.evaluation.judging import JudgeLimits
from spatial_relations_ros.evaluation.judging.solid import Solid, solid_of

FloatArray = NDArray[np.float64]
Bools = NDArray[np.bool_]

INSIDE = (Relation.INSIDE, Relation.INSIDE_LYING, Relation.INSIDE_INCLINED)

_GRID = 48
_BELOW_RIM = 0.1
_NUM_HEADINGS = 18
_LEAST_SHARE = 0.96


def impossible_reason(relation: Relation, base: TriangleMesh, relative: TriangleMesh) -> str:
    """Why two objects cannot show a relation, in words; empty when they may.

    Args:
        relation: wanted.
        base: watertight mesh.
        relative: watertight mesh.

    Raises:
        InvalidSceneError: for a mesh that is flat or encloses no volume.
    """
    if relation not in INSIDE:
        return ''
    container = solid_of(base)
    hollow = container.hollow
    if hollow is None or hollow.depth / hollow.width < JudgeLimits().container_depth:
        return 'the base is no container'
    if relation is Relation.INSIDE_LYING:
        upwards = -container.rest_directions @ hollow.opening
        if not (np.abs(upwards) < JudgeLimits().opening_up).any():
            return 'the base does not lie on its side'
    return '' if _fits(container, solid_of(relative)) else 'the relative does not fit in'


def _fits(container: Solid, solid: Solid) -> bool:
    """Whether one of the relative's sections goes far enough into the hollow, at some heading."""
    hollow = container.hollow
    assert hollow is not None
    for outline, length in _sections(solid.mesh):
        needed = JudgeLimits().sunk * min(hollow.depth, length)
        cell, rim = _free_cells(container, _BELOW_RIM * hollow.depth)
        room = rim & _free_cells(container, needed)[1]
        hull = ConvexHull(outline).equations
        for angle in np.arange(_NUM_HEADINGS) * (np.pi / _NUM_HEADINGS):
            if _has_place(room, _filled(hull, outline, angle, cell)):
                return True
    return False


def _has_place(room: Bools, shape: Bools) -> bool:
    """Whether a shape lies within a room somewhere, both as cells."""
    if any(needed > there for needed, there in zip(shape.shape, room.shape, strict=True)):
        return False
    covered = fftconvolve(room.astype(np.float64), shape[::-1, ::-1].astype(np.float64), 'valid')
    # Single cells of the room are missing where rays slip between triangles.
    return bool(covered.max() > _LEAST_SHARE * shape.sum())


@lru_cache(maxsize=512)
def _free_cells(container: Solid, depth: float) -> tuple[float, Bools]:
    """Cells (48, 48) across the opening's axis that are free in the hollow, below its rim.

    Returns:
        Edge of a cell in metres, and which are free.
    """
    hollow = container.hollow
    assert hollow is not None
    across = _across(hollow.opening)
    vertices = container.mesh.vertices.astype(np.float64) @ across.T
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    cell = float(np.ptp(vertices, axis=0).max()) / _GRID
    steps = cell * (np.arange(_GRID) - 0.5 * (_GRID - 1))
    grid = middle + np.stack(np.meshgrid(steps, steps, indexing='ij'), axis=-1).reshape(-1, 2)
    points = grid @ across + (hollow.rim - depth) * hollow.opening
    free = container.signed_distance(points) > 0.0
    free &= hollow.encloses(container.rays, points)
    return cell, free.reshape(_GRID, _GRID)


def _filled(hull: FloatArray, outline: FloatArray, angle_rad: float, cell: float) -> Bools:
    """Cells whose middles are within a turned convex outline."""
    turn = np.array(
        [[np.cos(angle_rad), -np.sin(angle_rad)], [np.sin(angle_rad), np.cos(angle_rad)]]
    )
    half = np.abs(outline @ turn.T).max(axis=0)
    counts = 2 * np.ceil(half / cell).astype(np.int64) + 1
    steps = [cell * (np.arange(count) - count // 2) for count in counts]
    middles = np.stack(np.meshgrid(*steps, indexing='ij'), axis=-1) @ turn
    inside = (middles @ hull[:, :2].T + hull[:, 2]).max(axis=-1) <= 0.0
    inside = inside[inside.any(axis=1)][:, inside.any(axis=0)]
    return np.asarray(inside if inside.size else np.ones((1, 1), dtype=bool))


@lru_cache(maxsize=256)
def _sections(mesh: TriangleMesh) -> tuple[tuple[FloatArray, float], ...]:
    """Outlines (V, 2) along the mesh's own and its principal axes, with the lengths along them."""
    vertices = mesh.vertices.astype(np.float64)
    _, axes = np.linalg.eigh(np.cov(vertices.T))
    sections = []
    for turned in (vertices, vertices @ axes):
        for axis in range(3):
            outline = np.delete(turned, axis, axis=1)
            outline = outline[ConvexHull(outline).vertices]
            middle = 0.5 * (outline.min(axis=0) + outline.max(axis=0))
            sections.append((outline - middle, float(np.ptp(turned[:, axis]))))
    return tuple(sections)


def _across(axis: FloatArray) -> FloatArray:
    """Two unit vectors (2, 3) normal to an axis and to each other."""
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first)])
