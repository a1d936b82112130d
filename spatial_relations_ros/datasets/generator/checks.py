"""Whether a placed pair really is in the wanted relation, at rest and without penetration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spatial_relations_ros.core import Relation
from spatial_relations_ros.core.rotations import tilt_angle_rad
from spatial_relations_ros.datasets.generator.body import FloatArray, Placed
from spatial_relations_ros.datasets.generator.contact import MAX_PENETRATION, clearance
from spatial_relations_ros.datasets.generator.stability import (
    RestingContacts,
    is_stable,
    resting_contacts,
)

MAX_CONTACT_GAP = 0.0015


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
    base_vertices, relative_vertices = base.world_vertices, relative.world_vertices
    base_top = float(base_vertices[:, 2].max())
    bottom, top = float(relative_vertices[:, 2].min()), float(relative_vertices[:, 2].max())
    opening = base.body.model.opening
    if relation in (Relation.ON_TOP, Relation.ON_TOP_EDGE):
        if bottom < 0.003:
            return 'on the table'
        if base.body.model.is_container and bottom < base_top - 0.008:
            return 'inside, not on top'
        if bottom < 0.5 * base_top:
            return 'beside, not on top'
    if relation in (Relation.INSIDE, Relation.INSIDE_INCLINED):
        assert opening is not None
        rim = float(base.translation[2] + opening.rim_z)
        reached = (rim - bottom) / min(opening.depth, top - bottom)
        least = 0.5 if relation is Relation.INSIDE else 0.35
        # A tall carton on the floor of a frying pan is not inside of it.
        if reached < least or rim - bottom < 0.2 * (top - bottom):
            return 'not deep enough'
    if relation is Relation.INSIDE_INCLINED and top < base_top + 0.008:
        return 'below the rim'
    if relation is Relation.INSIDE_LYING:
        return _lying_reason(base, relative_vertices)
    return ''


def _lying_reason(base: Placed, relative_vertices: FloatArray) -> str:
    opening = base.body.model.opening
    assert opening is not None
    local = base.to_object(relative_vertices)
    inside = opening.rim_z - float(local[:, 2].min())
    length = float(np.ptp(local[:, 2]))
    if inside < 0.3 * min(opening.depth, length):
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


def overhang(base: Placed, relative: Placed) -> float:
    """Largest reach of the relative beyond the base's outline, as a share of its own width."""
    shares = []
    for angle in np.arange(0.0, 2.0 * np.pi, np.pi / 12.0):
        direction = np.array([np.cos(angle), np.sin(angle), 0.0])
        beyond = (relative.world_vertices @ direction).max() - (
            base.world_vertices @ direction
        ).max()
        width = np.ptp(relative.world_vertices @ direction)
        shares.append(beyond / width)
    return float(max(shares))
