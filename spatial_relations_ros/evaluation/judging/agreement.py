"""Whether a result shows the reference's relation: its class, and how it is carried out."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from spatial_relations_ros.core import Relation
from spatial_relations_ros.evaluation.judging.judge import Judgement
from spatial_relations_ros.evaluation.judging.measures import Measures

_INSIDE = (Relation.INSIDE, Relation.INSIDE_LYING, Relation.INSIDE_INCLINED)
_ON_TOP = (Relation.ON_TOP, Relation.ON_TOP_EDGE)
_LEANING = (Relation.INCLINED, Relation.INSIDE_INCLINED)


@dataclass(frozen=True)
class Tolerances:
    """How far the continuous part of a relation may be from the reference's.

    Objects differ in size and shape, so lengths are compared as shares. The defaults are wide: a
    box can not hang over a plate in just the way in which a bowl hangs over a tray.

    Attributes:
        tilt_rad: of the angle by which the relative leans, where it leans.
        height: of the height of the relative's middle in the scene, as a share of the scene's
            height (0 at the table, 1 at the top).
        offset: of the horizontal distance of the mass centres, whatever its direction, as a share
            of the sum of both objects' diameters.
        overhang: of the foot's share over the edge, where the relative is on top.
        enclosed: of the share in the hollow, where the relative is inside.
    """

    tilt_rad: float = math.radians(25.0)
    height: float = 0.25
    offset: float = 0.2
    overhang: float = 0.3
    enclosed: float = 0.4


DEFAULT_TOLERANCES = Tolerances()


@dataclass(frozen=True)
class Agreement:
    """How a result compares with the reference.

    Attributes:
        same_class: whether both show the same relation.
        differences: in words; one a quantity that is out of tolerance, or the classes.
    """

    same_class: bool
    differences: tuple[str, ...]

    @property
    def same_relation(self) -> bool:
        """The same class, and the continuous part within tolerance."""
        return self.same_class and not self.differences


def compare_relations(
    reference: Judgement, result: Judgement, tolerances: Tolerances = DEFAULT_TOLERANCES
) -> Agreement:
    """Compares two judged scenes: the class, then the quantities that matter for it."""
    if result.relation is None or result.relation is not reference.relation:
        wanted, got = (
            'no relation' if judged.relation is None else judged.relation.description
            for judged in (reference, result)
        )
        return Agreement(False, (f'{got} instead of {wanted} ({result.reason})',))
    relation, want, have = result.relation, reference.measures, result.measures
    pairs = [
        ('height', height_share(want), height_share(have), tolerances.height),
        ('offset', offset_share(want), offset_share(have), tolerances.offset),
    ]
    if relation in _LEANING:
        pairs.append(('tilt', want.tilt_rad, have.tilt_rad, tolerances.tilt_rad))
    if relation in _ON_TOP:
        pairs.append(('overhang', overhang_share(want), overhang_share(have), tolerances.overhang))
    if relation in _INSIDE:
        pairs.append(('enclosed share', want.enclosed, have.enclosed, tolerances.enclosed))
    return Agreement(
        True,
        tuple(
            f'{name} {got:.2f} instead of {wanted:.2f} (+- {tolerance:.2f})'
            for name, wanted, got, tolerance in pairs
            if abs(got - wanted) > tolerance
        ),
    )


def height_share(measures: Measures) -> float:
    """Height of the relative's middle, 0 at the scene's lowest point and 1 at its top."""
    bottom = min(measures.base_bottom, measures.relative_bottom)
    top = max(
        measures.base_bottom + measures.base_height,
        measures.relative_bottom + measures.relative_height,
    )
    middle = measures.relative_bottom + 0.5 * measures.relative_height
    return (middle - bottom) / max(top - bottom, 1e-6)


def offset_share(measures: Measures) -> float:
    """Horizontal distance of the mass centres, as a share of the sum of the diameters."""
    distance = float(np.hypot(measures.offset[0], measures.offset[1]))
    return distance / (measures.base_diameter + measures.relative_diameter)


def overhang_share(measures: Measures) -> float:
    """Share of the relative's foot beyond what carries it, 0 where it lies within."""
    if measures.footing is None:
        return 0.0
    return float(np.clip(measures.footing.overhang, 0.0, 1.0))
