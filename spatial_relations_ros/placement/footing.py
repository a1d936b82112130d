"""How an object's foot lies on the outline of what carries it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.placement.body import FloatArray, Placed

FOOT_BAND = 0.002
SUPPORT_BAND = 0.003
# On top: either this far from the border, as a share of the scene and of the support ...
INNER_MARGIN_OF_SCENE = 0.03
INNER_MARGIN_OF_SUPPORT = 0.08
# ... or centred to this share of the smaller of foot and support.
CENTRED_SHARE = 0.1
OUTER_CENTRED_SHARE = 0.15
# At the edge: this much hangs over, as a share of the foot and of the scene ...
LEAST_OVERHANG_OF_FOOT = 0.25
LEAST_OVERHANG_OF_SCENE = 0.045
# ... and on the other side the support shows beyond the whole relative, as a share of the scene.
LEAST_SHOWN_OF_SCENE = 0.02

_LEAST_WIDTH = 1e-4
_NUM_DIRECTIONS = 48
_ANGLES = np.arange(_NUM_DIRECTIONS) * (2.0 * np.pi / _NUM_DIRECTIONS)
_DIRECTIONS = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)])


@dataclass(frozen=True, eq=False)
class Footing:
    """Reaches (48,) of three outlines along horizontal directions, metres.

    Attributes:
        foot: of the relative's lowest 2 mm.
        outline: of the whole relative seen from above.
        support: of the base's part from 3 mm below the relative's lowest point upwards.
        base: of the whole base seen from above.
        extent: the longest side of the scene's bounding box.
    """

    foot: FloatArray
    outline: FloatArray
    support: FloatArray
    base: FloatArray
    extent: float

    @staticmethod
    def of(base: Placed, relative: Placed) -> Footing:
        """Measures a placed pair."""
        upper, lower = relative.world_points, base.world_points
        bottom = float(upper[:, 2].min())
        foot = upper[upper[:, 2] < bottom + FOOT_BAND, :2]
        carrying = lower[lower[:, 2] > bottom - SUPPORT_BAND, :2]
        support = _reach(carrying) if len(carrying) else np.full(_NUM_DIRECTIONS, -np.inf)
        return Footing(
            _reach(foot),
            _reach(upper[:, :2]),
            support,
            _reach(lower[:, :2]),
            scene_extent(base, relative),
        )

    @cached_property
    def overhang(self) -> FloatArray:
        """Reach of the foot beyond the support (48,), negative within it, metres."""
        return self.foot - self.support

    @property
    def is_carried(self) -> bool:
        """Whether any of the base reaches up to the relative's lowest point."""
        return bool(np.isfinite(self.support).all())

    @property
    def foot_width(self) -> FloatArray:
        """(48,) metres."""
        return self.foot + _opposite(self.foot)

    @property
    def support_width(self) -> FloatArray:
        """(48,) metres."""
        return self.support + _opposite(self.support)

    @property
    def offset(self) -> FloatArray:
        """Of the foot's middle from the support's middle (48,), metres."""
        return 0.5 * (self.overhang - _opposite(self.overhang))

    @property
    def overhang_share(self) -> float:
        """The largest overhang as a share of the foot's width in that direction."""
        return float((self.overhang / np.maximum(self.foot_width, 1e-4)).max())

    def on_top_reason(self) -> str:
        """Why the foot is not clearly away from the border nor clearly centred."""
        if not self.is_carried:
            return 'no contact'
        smaller = np.minimum(self.foot_width, self.support_width)
        margin = np.maximum(
            INNER_MARGIN_OF_SCENE * self.extent, INNER_MARGIN_OF_SUPPORT * self.support_width
        )
        within = -self.overhang >= margin
        centred = np.abs(self.offset) <= CENTRED_SHARE * smaller + 1e-3
        if not (within | centred).all():
            return 'near the edge'
        outer_within = self.outline <= self.support
        nearly_centred = np.abs(self.offset) <= OUTER_CENTRED_SHARE * smaller + 1e-3
        if not (outer_within | nearly_centred).all():
            return 'reaches over the edge'
        # Centred on the upper step of stairs, over which it hangs, it is at their edge as well.
        return 'over a step' if (self._hangs & self._shows(self.base)).any() else ''

    def edge_reason(self) -> str:
        """Why the foot does not clearly hang over the border on one side."""
        if not self.is_carried:
            return 'no contact'
        if not self._hangs.any():
            return 'hardly over the edge'
        return '' if (self._hangs & self._shows(self.support)).any() else 'over both edges'

    @property
    def _hangs(self) -> NDArray[np.bool_]:
        """Where (48,) the foot clearly reaches over the support."""
        least = np.maximum(
            LEAST_OVERHANG_OF_FOOT * self.foot_width, LEAST_OVERHANG_OF_SCENE * self.extent
        )
        return np.asarray(self.overhang >= least)

    def _shows(self, reach: FloatArray) -> NDArray[np.bool_]:
        """Where (48,) an outline shows beyond the whole relative on the opposite side."""
        shown = _opposite(reach - self.outline) >= LEAST_SHOWN_OF_SCENE * self.extent
        return np.asarray(shown)


@dataclass(frozen=True)
class Overhang:
    """How far a foot hangs over what carries it.

    On the side on which it does so most, and most more than on the other side: a board on a can
    hangs over everywhere.

    Attributes:
        share: its reach beyond the carrier there, as a share of the foot's width; negative within.
        off_centre: shift of the foot's middle from the carrier's in that direction, as a share of
            the smaller of both widths.
    """

    share: float
    off_centre: float

    @staticmethod
    def of(foot: FloatArray, carrier: FloatArray) -> Overhang:
        """Compares points (N, 2) of a foot with points (M, 2) of what carries it."""
        foot_reach, carrier_reach = _reach(foot), _reach(carrier)
        foot_width = np.maximum(foot_reach + _opposite(foot_reach), _LEAST_WIDTH)
        carrier_width = np.maximum(carrier_reach + _opposite(carrier_reach), _LEAST_WIDTH)
        beyond = foot_reach - carrier_reach
        most = int(((beyond - np.maximum(_opposite(beyond), 0.0)) / foot_width).argmax())
        shift = 0.5 * (beyond - _opposite(beyond)) / np.minimum(foot_width, carrier_width)
        return Overhang(float((beyond / foot_width)[most]), float(shift[most]))


def scene_extent(base: Placed, relative: Placed) -> float:
    """The longest side of the bounding box of both, metres."""
    low = np.minimum(base.world_vertices.min(axis=0), relative.world_vertices.min(axis=0))
    high = np.maximum(base.world_vertices.max(axis=0), relative.world_vertices.max(axis=0))
    return float((high - low).max())


def _reach(points: FloatArray) -> FloatArray:
    reach: FloatArray = (points @ _DIRECTIONS).max(axis=0)
    return reach


def _opposite(values: FloatArray) -> FloatArray:
    return np.roll(values, _NUM_DIRECTIONS // 2)
