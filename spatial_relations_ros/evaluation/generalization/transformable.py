"""Which pairs of objects can show a relation at all, by their shapes.

After the paper, only containment excludes pairs: the base must be a container and the relative
must go through its opening.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import Relation, TriangleMesh
from spatial_relations_ros.evaluation.judging import JudgeLimits
from spatial_relations_ros.evaluation.judging.outline import outline_middle
from spatial_relations_ros.evaluation.judging.solid import Solid, solid_of

FloatArray = NDArray[np.float64]

INSIDE = (Relation.INSIDE, Relation.INSIDE_LYING, Relation.INSIDE_INCLINED)

_GRID = 48
_BELOW_RIM = 0.15
_NUM_HEADINGS = 18
_NUM_DIRECTIONS = 36


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
    """Whether one of the relative's narrow sections goes through the opening, middle on middle."""
    opening = _opening(container)
    if not len(opening):
        return False
    reach = (opening - outline_middle(opening)) @ _around(_NUM_DIRECTIONS)
    room = reach.max(axis=0)
    for outline in _sections(solid.mesh):
        for angle in np.arange(_NUM_HEADINGS) * (np.pi / _NUM_HEADINGS):
            turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
            turned = outline @ turn.T
            if ((turned @ _around(_NUM_DIRECTIONS)).max(axis=0) <= room).all():
                return True
    return False


@lru_cache(maxsize=256)
def _opening(container: Solid) -> FloatArray:
    """Points (N, 2) of the hollow's section just below the rim, across the opening's axis."""
    hollow = container.hollow
    assert hollow is not None
    across = _across(hollow.opening)
    vertices = container.mesh.vertices.astype(np.float64) @ across.T
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    grid = np.stack(np.meshgrid(*np.linspace(low, high, _GRID).T), axis=-1).reshape(-1, 2)
    level = hollow.rim - _BELOW_RIM * hollow.depth
    points = grid @ across + level * hollow.opening
    free = container.signed_distance(points) > 0.0
    inside = free & hollow.encloses(container.rays, points)
    return np.asarray(grid[inside])


@lru_cache(maxsize=256)
def _sections(mesh: TriangleMesh) -> tuple[FloatArray, ...]:
    """Outlines (V, 2) along the three principal axes, about their middles."""
    vertices = mesh.vertices.astype(np.float64)
    _, axes = np.linalg.eigh(np.cov(vertices.T))
    outlines = [vertices @ np.delete(axes, idx, axis=1) for idx in range(3)]
    outlines += [np.delete(vertices, idx, axis=1) for idx in range(3)]
    return tuple(outline - outline_middle(outline) for outline in outlines)


def _across(axis: FloatArray) -> FloatArray:
    """Two unit vectors (2, 3) normal to an axis and to each other."""
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first)])


def _around(count: int) -> FloatArray:
    """Directions (2, count) all around."""
    angles = np.arange(count) * (2.0 * np.pi / count)
    return np.stack([np.cos(angles), np.sin(angles)])
