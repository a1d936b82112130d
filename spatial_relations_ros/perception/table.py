"""The plane that the objects stand on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

NUM_HYPOTHESES = 64
MAX_FIT_POINTS = 1500
MIN_INLIERS = 40


@dataclass(frozen=True, eq=False)
class Plane:
    """Points p with ``normal @ p = offset``.

    Attributes:
        normal: (3,) unit vector, pointing up.
        offset: distance of the plane from the origin along the normal, metres.
    """

    normal: NDArray[np.float64]
    offset: float

    def heights(self, points: NDArray[np.floating]) -> NDArray[np.float64]:
        """Signed distances (N,) of points (N, 3) from the plane, positive above it."""
        heights: NDArray[np.float64] = points @ self.normal - self.offset
        return heights

    def z_at(self, x: float, y: float) -> float:
        """Height of the plane over a place on the ground; the plane must not be vertical."""
        return float((self.offset - self.normal[0] * x - self.normal[1] * y) / self.normal[2])


def find_table(
    points: NDArray[np.floating],
    rng: np.random.Generator,
    *,
    up: tuple[float, float, float] = (0.0, 0.0, 1.0),
    max_tilt_rad: float = 0.2,
    tolerance: float = 0.01,
    min_share: float = 0.15,
) -> Plane | None:
    """Finds the largest plane that is about level (RANSAC, then least squares on its points).

    Args:
        points: (N, 3) finite points, any frame.
        rng: picks the hypotheses.
        up: the direction against gravity in the points' frame.
        max_tilt_rad: the largest angle between the plane's normal and ``up``.
        tolerance: distance of a point that belongs to the plane, metres.
        min_share: share of the points that must belong to it.

    Returns:
        The plane with its normal along ``up``, or None when there is none.
    """
    stride = max(1, len(points) // MAX_FIT_POINTS)
    candidates = points[::stride].astype(np.float64)
    if len(candidates) < MIN_INLIERS:
        return None
    up_vector = np.asarray(up) / np.linalg.norm(up)
    corners = candidates[rng.integers(len(candidates), size=(NUM_HYPOTHESES, 3))]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    normals[normals @ up_vector < 0.0] *= -1.0
    is_level = normals @ up_vector > np.cos(max_tilt_rad) * np.maximum(lengths, 1e-9)
    if not is_level.any():
        return None
    normals = normals[is_level] / lengths[is_level, None]
    offsets = np.einsum('hi,hi->h', normals, corners[is_level, 0])
    counts = (np.abs(candidates @ normals.T - offsets) < tolerance).sum(axis=0)
    best = int(np.argmax(counts))
    if counts[best] < max(MIN_INLIERS, min_share * len(candidates)):
        return None
    plane = Plane(normals[best], float(offsets[best]))
    for _ in range(2):
        plane = _refined(
            plane, candidates[np.abs(plane.heights(candidates)) < tolerance], up_vector
        )
    return plane


def _refined(plane: Plane, inliers: NDArray[np.float64], up_vector: NDArray[np.float64]) -> Plane:
    if len(inliers) < MIN_INLIERS:
        return plane
    centre = inliers.mean(axis=0)
    _, vectors = np.linalg.eigh((inliers - centre).T @ (inliers - centre))
    normal = vectors[:, 0] if vectors[:, 0] @ up_vector > 0.0 else -vectors[:, 0]
    return Plane(normal, float(normal @ centre))
