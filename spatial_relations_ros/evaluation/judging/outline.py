"""Where two objects stand beside each other as seen from above, whatever their sizes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_NUM_DIRECTIONS = 36
_SAME_PLACE = 1e-6


@dataclass(frozen=True)
class OutlineOffset:
    """How far the relative's outline is beside the base's, seen from above.

    Attributes:
        distance: of the outlines' middles, metres.
        base_half_width, relative_half_width: of the outlines in the direction from one middle to
            the other, metres.
    """

    distance: float
    base_half_width: float
    relative_half_width: float

    @property
    def share(self) -> float:
        """The distance over the sum of both half widths.

        0 for one over the other, 1 for faces that touch side by side, more for a gap.
        """
        return self.distance / max(self.base_half_width + self.relative_half_width, _SAME_PLACE)

    def share_at(self, gap: float) -> float:
        """The share at which the outlines are a gap apart, metres."""
        return 1.0 + gap / max(self.base_half_width + self.relative_half_width, _SAME_PLACE)

    @property
    def share_within(self) -> float:
        """The share at which the smaller outline reaches the larger one's border from within."""
        widths = self.base_half_width, self.relative_half_width
        return (max(widths) - min(widths)) / max(sum(widths), _SAME_PLACE)


def outline_offset(base_points: FloatArray, relative_points: FloatArray) -> OutlineOffset:
    """Compares the outlines of two objects from points (N, 3), (M, 3) of them, world, z up."""
    away = outline_middle(relative_points) - outline_middle(base_points)
    distance = float(np.linalg.norm(away))
    direction = away / distance if distance > _SAME_PLACE else np.array([1.0, 0.0])
    base_half, relative_half = (
        0.5 * float(np.ptp(points[:, :2] @ direction)) for points in (base_points, relative_points)
    )
    return OutlineOffset(distance, base_half, relative_half)


def outline_middle(points: FloatArray) -> FloatArray:
    """Middle (2,) of an outline, the same at every heading.

    The point whose projections are nearest (least squares) to the middles of the outline's
    extents, over directions all around.
    """
    angles = np.arange(_NUM_DIRECTIONS) * (np.pi / _NUM_DIRECTIONS)
    directions = np.stack([np.cos(angles), np.sin(angles)])
    along = points[:, :2] @ directions
    middles = 0.5 * (along.min(axis=0) + along.max(axis=0))
    return np.asarray(directions @ middles * (2.0 / _NUM_DIRECTIONS))
