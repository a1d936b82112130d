"""How far a placement's arrangement is from the demonstration's."""

from __future__ import annotations

import math

from spatial_relations_ros.core import Scene
from spatial_relations_ros.imitation.shape import shape_of
from spatial_relations_ros.imitation.tabletop import Tabletop
from spatial_relations_ros.placement.arrangement import Arrangement

# What differs by this much is another way to show the relation.
_LEAN_RAD = math.radians(20.0)
_SHARE = 0.25
_HEIGHT = 0.15
_DEPTH = 0.35
# From here on something leans, is in the hollow, or is on the edge.
_LEANS_RAD = math.radians(10.0)
_IN_HOLLOW = 0.35
_EDGE_OVERHANG, _EDGE_SHIFT = 0.15, 0.145
_STANDS = 0.015
_AT_MOST = 2.0


def demonstrated_arrangement(reference: Scene) -> Arrangement | None:
    """The arrangement of a demonstration; None without meshes.

    Of clouds it would have to be guessed with the solids.
    """
    if any(item.mesh is None for item in reference.objects):
        return None
    base, relative = (shape_of(item) for item in reference.objects)
    lowest = min(float(item.world_points[:, 2].min()) for item in reference.objects)
    tabletop = Tabletop.of((base, relative), reference.base.world_from_object, lowest)
    return Arrangement.of(
        tabletop.placed(0, reference.base.world_from_object),
        tabletop.placed(1, reference.relative.world_from_object),
    )


def arrangement_difference(got: Arrangement, wanted: Arrangement) -> float:
    """How unlike two arrangements are: 0 for alike ones, up to 1 for each quantity that counts.

    A half means that a quantity is as far off as another way to show the relation.
    """
    shares = _differences(got, wanted)
    return sum(min(share, _AT_MOST) for share in shares) / _AT_MOST


def is_alike(got: Arrangement, wanted: Arrangement) -> bool:
    """Whether no quantity is so far off that the relation is shown in another way."""
    return max(_differences(got, wanted)) <= 1.0


def leans(arrangement: Arrangement) -> bool:
    """Whether the relative is tilted."""
    return arrangement.lean_rad > _LEANS_RAD


def rests_on_other(arrangement: Arrangement) -> bool:
    """Whether the relative is carried by the base alone, level."""
    return arrangement.foot >= _STANDS and not leans(arrangement)


def _differences(got: Arrangement, wanted: Arrangement) -> tuple[float, ...]:
    """Differences in shares of what makes another way, of the quantities that matter."""
    lean = _lean_difference(got.lean_rad, wanted.lean_rad)
    sunk = abs(got.sunk - wanted.sunk) / _DEPTH
    if wanted.sunk >= _IN_HOLLOW:
        return lean, sunk
    stands = abs(float(got.foot < _STANDS) - float(wanted.foot < _STANDS)) * _AT_MOST
    if leans(wanted) or wanted.foot < _STANDS:
        return lean, sunk, stands, abs(got.foot - wanted.foot) / _HEIGHT
    seat = abs(got.seat - wanted.seat) / _HEIGHT
    edge = abs(_edge(got) - _edge(wanted))
    return lean, sunk, stands, seat, max(edge, abs(got.overhang - wanted.overhang) / _SHARE)


def _lean_difference(got_rad: float, wanted_rad: float) -> float:
    """A plate on its rim leans as a book does: angles from the level or the vertical are alike."""
    if min(got_rad, wanted_rad) > _LEANS_RAD:
        got_rad, wanted_rad = (min(lean, 0.5 * math.pi - lean) for lean in (got_rad, wanted_rad))
    elif max(got_rad, wanted_rad) > _LEANS_RAD:
        return 1.0 + abs(got_rad - wanted_rad) / _LEAN_RAD
    return abs(got_rad - wanted_rad) / _LEAN_RAD


def _edge(arrangement: Arrangement) -> float:
    """From 0 for well within to 2 for well over the edge; 1 is where the edge begins."""
    over = min(arrangement.overhang / _EDGE_OVERHANG, arrangement.off_centre / _EDGE_SHIFT)
    return min(over, _AT_MOST)
