"""Whether a result shows the reference's relation: its class, and how it is carried out.

Objects differ in size and shape, so nothing is compared that the shapes alone decide: heights
count from the surface that matters for the relation, offsets are shares of the outlines' widths,
and what the test objects cannot reach is not asked of them. :mod:`..generalization.reachability`
measures how many pairs of objects can agree with how many references.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from spatial_relations_ros.core import Relation
from spatial_relations_ros.evaluation.judging.judge import JudgeLimits, Judgement
from spatial_relations_ros.evaluation.judging.measures import Measures


@dataclass(frozen=True)
class Tolerances:
    """How far the continuous part of a relation may be from the reference's.

    Attributes:
        offset: of :attr:`OutlineOffset.share`, whatever the direction: the distance of the
            outlines' middles seen from above over the sum of their half widths. Beyond 1, that is
            with a gap between them, the tolerance grows with the reference's share.
        lean_rad: of the angle between the relative and the nearest way to stand on a face or, at
            a right angle to it, on an edge: a plate on its rim leans as a book does.
        foot: of the height of the relative's lowest point over that of the base, where it leans
            from the table, as a share of the scene's height.
        seat: of the height of the contacts over the base's top, where the relative is on top, or
            of its middle if that is lower, as a share of the scene's height; what hangs down
            beside the contacts is not asked for as long as half of it is above.
        overhang: of the foot's share over the edge.
        sunk: of how deep the relative sits in the hollow, as a share of what can be below the rim.
    """

    offset: float = 0.3
    lean_rad: float = math.radians(20.0)
    foot: float = 0.1
    seat: float = 0.2
    overhang: float = 0.25
    sunk: float = 0.35


DEFAULT_TOLERANCES = Tolerances()


@dataclass(frozen=True)
class Difference:
    """A quantity of a relation that is out of tolerance.

    Attributes:
        quantity: its name.
        wanted, got: of the reference, as far as the test objects can reach it, and of the result.
        tolerance: of their difference.
    """

    quantity: str
    wanted: float
    got: float
    tolerance: float

    def __str__(self) -> str:
        return (
            f'{self.quantity} {self.got:.2f} instead of {self.wanted:.2f} +- {self.tolerance:.2f}'
        )


@dataclass(frozen=True)
class Agreement:
    """How a result compares with the reference.

    Attributes:
        same_class: whether both show the same relation.
        differences: quantities that are out of tolerance; none when the classes differ.
        class_difference: what the result is instead, in words; empty when the classes agree.
    """

    same_class: bool
    differences: tuple[Difference, ...] = ()
    class_difference: str = ''

    @property
    def same_relation(self) -> bool:
        """The same class, and the continuous part within tolerance."""
        return self.same_class and not self.differences

    @property
    def words(self) -> tuple[str, ...]:
        """All that differs."""
        return tuple(filter(None, (self.class_difference, *map(str, self.differences))))


def compare_relations(
    reference: Judgement, result: Judgement, tolerances: Tolerances = DEFAULT_TOLERANCES
) -> Agreement:
    """Compares two judged scenes: the class, then the quantities that matter for it."""
    if result.relation is None or result.relation is not reference.relation:
        wanted, got = (
            'no relation' if judged.relation is None else judged.relation.description
            for judged in (reference, result)
        )
        return Agreement(False, (), f'{got} instead of {wanted} ({result.reason})')
    compared = (
        quantity(reference.measures, result.measures, tolerances)
        for quantity in _QUANTITIES[result.relation]
    )
    return Agreement(
        True, tuple(item for item in compared if abs(item.got - item.wanted) > item.tolerance)
    )


def _gap(want: Measures, have: Measures, tolerances: Tolerances) -> Difference:
    """The offset of two that stand beside each other, as far as the gap is one of neighbours."""
    wanted = min(want.outline.share, have.outline.share_at(JudgeLimits().next_to_gap))
    return Difference('offset', wanted, have.outline.share, tolerances.offset * max(1.0, wanted))


def _offset_within(want: Measures, have: Measures, tolerances: Tolerances) -> Difference:
    """The offset of one on or in the other: no farther out than the smaller one fits."""
    wanted = min(want.outline.share, have.outline.share_within)
    return Difference('offset', wanted, have.outline.share, tolerances.offset)


def _lean(want: Measures, have: Measures, tolerances: Tolerances) -> Difference:
    wanted, got = (
        min(measures.tilt_rad, abs(0.5 * math.pi - measures.tilt_rad)) for measures in (want, have)
    )
    return Difference('lean', wanted, got, tolerances.lean_rad)


def _foot(want: Measures, have: Measures, tolerances: Tolerances) -> Difference:
    wanted, got = (
        (measures.relative_bottom - measures.base_bottom) / scene_height(measures)
        for measures in (want, have)
    )
    return Difference('height of the foot', wanted, got, tolerances.foot)


def _seat(want: Measures, have: Measures, tolerances: Tolerances) -> Difference:
    wanted, got = (
        (measures.seat_height - measures.base_bottom - measures.base_height)
        / scene_height(measures)
        for measures in (want, have)
    )
    return Difference("height over the base's top", wanted, got, tolerances.seat)


def _overhang(want: Measures, have: Measures, tolerances: Tolerances) -> Difference:
    return Difference('overhang', overhang_share(want), overhang_share(have), tolerances.overhang)


def _sunk(want: Measures, have: Measures, tolerances: Tolerances) -> Difference:
    return Difference('depth in the hollow', want.sunk, have.sunk, tolerances.sunk)


_Quantity = Callable[[Measures, Measures, Tolerances], Difference]

_QUANTITIES: dict[Relation, tuple[_Quantity, ...]] = {
    Relation.ON_TOP: (_seat, _offset_within),
    Relation.INSIDE: (_sunk, _offset_within),
    Relation.NEXT_TO: (_gap,),
    Relation.INCLINED: (_lean, _foot),
    Relation.ON_TOP_EDGE: (_seat, _overhang),
    Relation.INSIDE_LYING: (_sunk,),
    Relation.INSIDE_INCLINED: (_lean, _sunk),
}


def scene_height(measures: Measures) -> float:
    """From the lowest to the highest point of both objects, metres."""
    bottom = min(measures.base_bottom, measures.relative_bottom)
    top = max(
        measures.base_bottom + measures.base_height,
        measures.relative_bottom + measures.relative_height,
    )
    return max(top - bottom, 1e-6)


def overhang_share(measures: Measures) -> float:
    """Share of the relative's foot beyond what carries it, 0 where it lies within."""
    if measures.footing is None:
        return 0.0
    return float(np.clip(measures.footing.overhang, 0.0, 1.0))
