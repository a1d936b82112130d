"""How one placed body is arranged around another, in quantities that do not depend on size."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.placement.body import FloatArray, Placed
from spatial_relations_ros.placement.contact import find_contacts
from spatial_relations_ros.placement.footing import Overhang
from spatial_relations_ros.placement.leaning import lean_angle_rad
from spatial_relations_ros.placement.model import Opening

# Where the base is round or rugged, what is a little below the foot still counts as carrying it.
_FOOT_BAND = 0.003
_CARRIER_BAND = 0.006
_CONTACT_GAP = 0.003
# Less of its surface in the hollow does not make a body inside of it ...
_LEAST_INSIDE = 0.12
# ... and in a hollow that is less deep, as a share of its width, it stands as on a plate, unless
# hardly anything of it towers above the rim.
_CONTAINER_DEPTH, _LEAST_INSIDE_DISH = 0.19, 0.75
_TINY = 1e-6


@dataclass(frozen=True)
class Arrangement:
    """What of a relation is neither the class nor the horizontal spacing.

    Attributes:
        lean_rad: angle of the relative to the nearest way in which it stands.
        foot: height of the relative's lowest point over the table, as a share of the scene's.
        seat: height over the base's top of the contacts, or of the relative's middle if that is
            lower, as a share likewise, negative below it; of the lowest point without contacts.
        overhang: the share of the relative's foot beyond what carries it; 0 where it lies within,
            or stands on the table.
        off_centre: shift of the foot from the middle of what carries it in that direction, as a
            share of the smaller of both.
        sunk: how deep the relative is in the base's hollow, as a share of what can be below the
            rim; 0 outside.
    """

    lean_rad: float
    foot: float
    seat: float
    overhang: float
    off_centre: float
    sunk: float

    @staticmethod
    def of(base: Placed, relative: Placed) -> Arrangement:
        """Measures a pair on the table z = 0."""
        bottoms, tops = zip(*(_vertical_range(body) for body in (base, relative)), strict=True)
        height = max(max(tops) - min(bottoms), _TINY)
        over, seat = Overhang(0.0, 0.0), bottoms[1]
        if bottoms[1] > _FOOT_BAND:
            over = _overhang(base, relative, bottoms[1])
            if bottoms[1] < tops[0] - _FOOT_BAND:
                seat = _seat(base, relative)
        return Arrangement(
            lean_rad=lean_angle_rad(relative),
            foot=(bottoms[1] - bottoms[0]) / height,
            seat=(seat - tops[0]) / height,
            overhang=max(over.share, 0.0),
            off_centre=max(over.off_centre, 0.0),
            sunk=_sunk(base, relative),
        )


def _overhang(base: Placed, relative: Placed, bottom: float) -> Overhang:
    upper, lower = relative.world_points, base.world_points
    foot = upper[upper[:, 2] < bottom + _FOOT_BAND, :2]
    carrier = lower[lower[:, 2] > bottom - _CARRIER_BAND, :2]
    return Overhang.of(foot, carrier) if len(carrier) > 2 else Overhang(1.0, 1.0)


def _seat(base: Placed, relative: Placed) -> float:
    """Mean height of the contacts, or of the middle; parts may hang down beside the contacts."""
    bottom, top = _vertical_range(relative)
    contacts = find_contacts(base.coarse(), relative.coarse(), gap=_CONTACT_GAP).points
    return min(float(contacts[:, 2].mean()), 0.5 * (bottom + top)) if len(contacts) else bottom


def _sunk(base: Placed, relative: Placed) -> float:
    opening = base.body.model.opening
    if opening is None:
        return 0.0
    local = base.to_object(relative.world_points).astype(np.float64)
    within = _within(local[:, :2] - opening.centre, opening.rim_half_size, opening.is_round)
    depths = opening.rim_z - local[within, 2]
    depths = depths[(depths > 0.0) & (depths < 1.1 * opening.depth)]
    if len(depths) < (_LEAST_INSIDE_DISH if _is_dish(opening) else _LEAST_INSIDE) * len(local):
        return 0.0
    length = float(np.ptp(local[:, 2]))
    deepest = float(depths.max()) / max(min(opening.depth, length), _TINY)
    return float(np.clip(deepest, 0.0, 1.0))


def _is_dish(opening: Opening) -> bool:
    return opening.depth < _CONTAINER_DEPTH * 2.0 * min(opening.rim_half_size)


def _within(
    places: FloatArray, half_size: tuple[float, float], is_round: bool
) -> NDArray[np.bool_]:
    shares = np.abs(places) / np.maximum(half_size, _TINY)
    if is_round:
        return np.asarray((shares**2).sum(axis=1) < 1.0)
    return np.asarray((shares < 1.0).all(axis=1))


def _vertical_range(placed: Placed) -> tuple[float, float]:
    heights = placed.world_vertices[:, 2]
    return float(heights.min()), float(heights.max())
