"""Whether a placed solid stays where it is: static equilibrium with friction."""

from __future__ import annotations

import weakref

from spatial_relations_ros.imitation.contact import Body
from spatial_relations_ros.imitation.solids import hand_scale, solid_of
from spatial_relations_ros.placement.body import Placed
from spatial_relations_ros.placement.contact import Contacts, find_contacts, table_contacts
from spatial_relations_ros.placement.stability import (
    TABLE_TILT_RAD,
    RestingContacts,
    holds_still,
    is_stable,
)

# Placements are exact; poses of what stands already come from a tracker.
_TRACKED_GAP = 0.0015

Touching = tuple[Contacts, Contacts, Contacts]


def stays(body: Body, other: Body, table_height: float) -> bool:
    """Whether friction of 0.5 holds a body at rest on the table and on another one.

    Also on a table that is tilted by 4 degrees, which leaves out what would fall at a touch. The
    other body must bear the load without tipping, if it stands at all without it: one whose pose
    is off the table, or that something else holds, is taken as fixed.
    """
    scale = hand_scale((body.shape, other.shape))
    return rests(*(_placed(item, table_height, scale) for item in (body, other)))


def rests(placed: Placed, fixed: Placed, *, tilt_rad: float = TABLE_TILT_RAD) -> bool:
    """The same for bodies on the table z = 0, and for another tilt."""
    on_table, between, below_other = _contacts(placed, fixed)
    if not holds_still(placed, [on_table, between], tilt_rad=tilt_rad):
        return False
    if not holds_still(fixed, [below_other]):
        return True
    contacts = RestingContacts(below_other, on_table, between)
    return is_stable(fixed, placed, contacts, tilt_rad=tilt_rad)


def stay_together(base: Body, relative: Body, table_height: float) -> bool:
    """Whether a base that is placed as exactly as the relative bears it without tipping."""
    scale = hand_scale((base.shape, relative.shape))
    return rest_together(*(_placed(item, table_height, scale) for item in (base, relative)))


def rest_together(base: Placed, relative: Placed, *, tilt_rad: float = TABLE_TILT_RAD) -> bool:
    """The same for bodies on the table z = 0, and for another tilt."""
    on_table, between, _ = _contacts(relative, base)
    contacts = RestingContacts(table_contacts(base), on_table, between)
    return is_stable(base, relative, contacts, tilt_rad=tilt_rad)


_known: weakref.WeakKeyDictionary[Placed, tuple[weakref.ref[Placed], Touching]] = (
    weakref.WeakKeyDictionary()
)


def _contacts(placed: Placed, fixed: Placed) -> Touching:
    """Of a body and the table, of both, of the other and the table.

    Kept for the last pair of a body: it is asked for at two tilts.
    """
    known = _known.get(placed)
    if known is not None and known[0]() is fixed:
        return known[1]
    touching = (
        table_contacts(placed),
        find_contacts(fixed, placed),
        table_contacts(fixed, gap=_TRACKED_GAP),
    )
    _known[placed] = weakref.ref(fixed), touching
    return touching


def _placed(body: Body, table_height: float, scale: float) -> Placed:
    """The body for checks whose table is at z = 0."""
    return solid_of(body.shape, scale).placed(body.pose, (0.0, 0.0, table_height))
