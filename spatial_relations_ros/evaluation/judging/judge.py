"""Which relation a scene shows, decided by geometry alone."""

from __future__ import annotations

import math
from dataclasses import dataclass

from spatial_relations_ros.core import Relation, Scene
from spatial_relations_ros.evaluation.judging.measures import (
    CONTACT_GAP,
    Measures,
    measure_scene,
)


@dataclass(frozen=True)
class JudgeLimits:
    """Where one relation ends and the next begins.

    The gaps and overlaps fit meshes at exact poses; tracked poses of real objects need wider ones.

    Attributes:
        contact_gap: objects that are no farther apart touch, metres.
        table_gap: an object no higher above the table stands on it, metres.
        lean_rad: tilted by more than this, an object leans.
        enclosed: share of the relative's surface in the hollow from which on it is inside ...
        sunk: ... and how deep it is, as a share of the hollow's or of its own depth.
        container_depth: a hollow that is less deep, as a share of its width, is that of a plate
            or a tray ...
        enclosed_in_tray: ... in which only what hardly towers above the rim is inside.
        opening_up: cosine to the vertical that separates upright containers from lying ones.
        overhang: share of the foot that reaches over the carrier from which on it is on the edge.
        off_centre: the least shift off the carrier's middle for that, as a share of the smaller.
        next_to_gap: objects farther apart are not next to each other, metres ...
        next_to_gap_of_size: ... or as a share of the larger one's diameter, where that is more.
        penetration: objects that overlap by more are in no relation, metres.
        below_table: likewise for the table, metres.
    """

    contact_gap: float = CONTACT_GAP
    table_gap: float = 0.004
    lean_rad: float = math.radians(10.0)
    enclosed: float = 0.15
    sunk: float = 0.35
    container_depth: float = 0.19
    enclosed_in_tray: float = 0.75
    opening_up: float = 0.7
    overhang: float = 0.15
    off_centre: float = 0.145
    next_to_gap: float = 0.2
    next_to_gap_of_size: float = 1.0
    penetration: float = 0.005
    below_table: float = 0.005


DEFAULT_LIMITS = JudgeLimits()


@dataclass(frozen=True, eq=False)
class Judgement:
    """What the judge says of a scene.

    Attributes:
        relation: of the relative to the base; None when it is none of the seven.
        reason: in words, why it is this relation or none.
        measures: the numbers behind it.
    """

    relation: Relation | None
    reason: str
    measures: Measures


def judge_scene(
    scene: Scene, table_height: float | None = None, *, limits: JudgeLimits = DEFAULT_LIMITS
) -> Judgement:
    """Decides which relation a scene shows.

    Neither the metric nor the generator's placing and checking code is asked.

    Args:
        scene: both objects with watertight meshes.
        table_height: z of the table in the scene's world, metres; the lowest point of both
            objects by default.
        limits: where relations end.

    Raises:
        InvalidSceneError: when a mesh is missing, flat, or encloses no volume.
    """
    measures = measure_scene(scene, table_height, contact_gap=limits.contact_gap)
    relation, reason = decide(measures, limits)
    return Judgement(relation, reason, measures)


def decide(
    measures: Measures, limits: JudgeLimits = DEFAULT_LIMITS
) -> tuple[Relation | None, str]:
    """The relation that the numbers of a scene show, and why."""
    if measures.clearance < -limits.penetration:
        return None, f'the objects overlap by {-1e3 * measures.clearance:.0f} mm'
    if measures.penetration_of_table > limits.below_table:
        return None, f'{1e3 * measures.penetration_of_table:.0f} mm below the table'
    if measures.base_bottom > limits.table_gap:
        return None, f'the base is {1e3 * measures.base_bottom:.0f} mm above the table'
    is_container = measures.hollow_depth >= limits.container_depth
    enclosed = limits.enclosed if is_container else limits.enclosed_in_tray
    if measures.enclosed >= enclosed and measures.sunk >= limits.sunk:
        return _inside(measures, limits)
    return _outside(measures, limits)


def _inside(measures: Measures, limits: JudgeLimits) -> tuple[Relation | None, str]:
    assert measures.opening_up is not None
    if measures.opening_up < -limits.opening_up:
        return None, 'the base stands upside down over the relative'
    if not measures.touches:
        return None, 'in the hollow without touching it'
    if measures.opening_up < limits.opening_up:
        return Relation.INSIDE_LYING, 'in a hollow that opens to the side'
    if measures.tilt_rad > limits.lean_rad:
        return Relation.INSIDE_INCLINED, f'in the hollow, tilted by {_degrees(measures.tilt_rad)}'
    return Relation.INSIDE, f'{100 * measures.enclosed:.0f} % of it are in the hollow, level'


def _outside(measures: Measures, limits: JudgeLimits) -> tuple[Relation | None, str]:
    stands = measures.relative_bottom <= limits.table_gap
    if not measures.touches:
        if not stands:
            return None, f'the relative floats {1e3 * measures.relative_bottom:.0f} mm high'
        return _apart(measures, limits)
    if measures.tilt_rad > limits.lean_rad:
        return Relation.INCLINED, f'leans by {_degrees(measures.tilt_rad)}'
    if stands:
        return Relation.NEXT_TO, 'both stand on the table and touch'
    return _on_top(measures, limits)


def _apart(measures: Measures, limits: JudgeLimits) -> tuple[Relation | None, str]:
    size = max(measures.base_diameter, measures.relative_diameter)
    if measures.clearance > max(limits.next_to_gap, limits.next_to_gap_of_size * size):
        return None, f'{100 * measures.clearance:.0f} cm apart'
    if measures.tilt_rad > limits.lean_rad:
        return None, f'tilted by {_degrees(measures.tilt_rad)}, and nothing to lean on'
    return Relation.NEXT_TO, f'on the table, {100 * measures.clearance:.1f} cm apart'


def _on_top(measures: Measures, limits: JudgeLimits) -> tuple[Relation | None, str]:
    footing = measures.footing
    if footing is None:
        return None, 'held from the side, with nothing below'
    over = f'{100 * max(footing.overhang, 0.0):.0f} % of the foot over the edge'
    if footing.overhang >= limits.overhang and footing.off_centre >= limits.off_centre:
        return Relation.ON_TOP_EDGE, over
    return Relation.ON_TOP, over


def _degrees(angle_rad: float) -> str:
    return f'{math.degrees(angle_rad):.0f} degrees'
