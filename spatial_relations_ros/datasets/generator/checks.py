"""Whether a placed pair really is in the wanted relation, at rest and without penetration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spatial_relations_ros.core import Relation
from spatial_relations_ros.core.rotations import tilt_angle_rad
from spatial_relations_ros.placement.body import FloatArray, Placed
from spatial_relations_ros.placement.contact import MAX_PENETRATION, clearance
from spatial_relations_ros.placement.footing import Footing
from spatial_relations_ros.placement.leaning import lean_angle_rad
from spatial_relations_ros.placement.stability import (
    RestingContacts,
    is_stable,
    resting_contacts,
)

MAX_CONTACT_GAP = 0.0015
LEAST_LEAN_RAD = float(np.deg2rad(12.5))
LEAST_HEIGHT_IN_HOLLOW = 1.6
_FLAT_HOLLOW = 0.015


@dataclass(frozen=True, eq=False)
class Measured:
    """A scene that passed: base and relative, and what was measured on it.

    Attributes:
        base, relative: at their poses on the table z = 0.
        clearance: smallest signed distance between the bodies, metres.
        contacts: where they touch each other and the table.
    """

    base: Placed
    relative: Placed
    clearance: float
    contacts: RestingContacts

    @property
    def base_tilt_rad(self) -> float:
        """Angle between the base's z axis and up."""
        return tilt_angle_rad(self.base.rotation)

    @property
    def tilt_rad(self) -> float:
        """Angle between the relative's z axis and up."""
        return tilt_angle_rad(self.relative.rotation)


def measure(relation: Relation, base: Placed, relative: Placed) -> Measured | str:
    """Checks a placement; returns the reason in words when it is refused."""
    lowest = min(base.world_vertices[:, 2].min(), relative.world_vertices[:, 2].min())
    if lowest < -1e-6:
        return 'below the table'
    reason = _shape_reason(relation, base, relative)
    if reason:
        return reason
    gap = clearance(base, relative)
    if gap < -MAX_PENETRATION:
        return 'penetration'
    if relation is not Relation.NEXT_TO and gap > MAX_CONTACT_GAP:
        return 'no contact'
    contacts = resting_contacts(base, relative)
    reason = _contact_reason(relation, contacts)
    if reason:
        return reason
    if not is_stable(base, relative, contacts):
        return 'not stable'
    return Measured(base, relative, gap, contacts)


def _shape_reason(relation: Relation, base: Placed, relative: Placed) -> str:
    """Cheap conditions on the bodies' extents."""
    if relation in (Relation.ON_TOP, Relation.ON_TOP_EDGE):
        return _on_top_reason(relation, base, relative)
    if relation is Relation.INSIDE:
        return _inside_reason(base, relative)
    if relation is Relation.INSIDE_INCLINED:
        return _inside_inclined_reason(base, relative)
    if relation is Relation.INSIDE_LYING:
        return _lying_reason(base, relative.world_vertices)
    if relation is Relation.INCLINED and lean_angle_rad(relative) < LEAST_LEAN_RAD:
        return 'hardly leans'
    return ''


def _on_top_reason(relation: Relation, base: Placed, relative: Placed) -> str:
    base_top = float(base.world_vertices[:, 2].max())
    bottom, top = _vertical_range(relative)
    if bottom < 0.003:
        return 'on the table'
    if bottom < base_top - 0.008 and not _in_hollow(base, bottom, top):
        return 'beside, not on top'
    footing = Footing.of(base, relative)
    return footing.on_top_reason() if relation is Relation.ON_TOP else footing.edge_reason()


def _in_hollow(base: Placed, bottom: float, top: float) -> bool:
    """Whether something stands in the hollow of an upright plate or tray and towers above it."""
    opening = base.body.model.opening
    if opening is None or base.body.model.is_container or base.rotation[2, 2] < 0.99:
        return False
    rim = float(base.translation[2] + opening.rim_z)
    least = LEAST_HEIGHT_IN_HOLLOW if opening.depth > _FLAT_HOLLOW else 1.0
    return top - bottom > least * (rim - bottom)


def _inside_reason(base: Placed, relative: Placed) -> str:
    return '' if _is_deep(base, relative, share=0.6) else 'not deep enough'


def _inside_inclined_reason(base: Placed, relative: Placed) -> str:
    if not _is_deep(base, relative, share=0.4):
        return 'not deep enough'
    return 'hardly leans' if lean_angle_rad(relative) < LEAST_LEAN_RAD else ''


def _is_deep(base: Placed, relative: Placed, *, share: float) -> bool:
    """Whether that share of what could be below the rim of an upright container is below it."""
    opening = base.body.model.opening
    assert opening is not None
    bottom, top = _vertical_range(relative)
    below_rim = float(base.translation[2] + opening.rim_z) - bottom
    # A tall carton on the floor of a frying pan is not inside of it.
    return below_rim >= share * min(opening.depth, top - bottom) and below_rim >= 0.25 * (
        top - bottom
    )


def _vertical_range(placed: Placed) -> tuple[float, float]:
    heights = placed.world_vertices[:, 2]
    return float(heights.min()), float(heights.max())


def _lying_reason(base: Placed, relative_vertices: FloatArray) -> str:
    opening = base.body.model.opening
    assert opening is not None
    local = base.to_object(relative_vertices)
    inside = opening.rim_z - float(local[:, 2].min())
    length = float(np.ptp(local[:, 2]))
    if inside < 0.4 * min(opening.depth, length) or inside < 0.3 * length:
        return 'not deep enough'
    return ''


def _contact_reason(relation: Relation, contacts: RestingContacts) -> str:
    touching, standing = len(contacts.base_relative), len(contacts.relative_table)
    if relation is Relation.NEXT_TO:
        return ''
    if not touching:
        return 'no contact'
    if relation is Relation.INCLINED:
        return '' if standing else 'off the table'
    if standing and relation is not Relation.INSIDE_LYING:
        return 'on the table'
    if relation is Relation.INSIDE_INCLINED:
        heights = contacts.base_relative.points[:, 2]
        if np.ptp(heights) < 0.02:
            return 'does not lean'
    return ''
