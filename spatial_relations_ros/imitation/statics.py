"""Whether a placed solid stays where it is: static equilibrium with friction."""

from __future__ import annotations

import weakref

import numpy as np

from spatial_relations_ros.core import TriangleMesh
from spatial_relations_ros.imitation.contact import Body
from spatial_relations_ros.imitation.shape import Shape
from spatial_relations_ros.placement.body import Body as SolidBody
from spatial_relations_ros.placement.body import Placed
from spatial_relations_ros.placement.contact import find_contacts, table_contacts
from spatial_relations_ros.placement.model import ObjectModel
from spatial_relations_ros.placement.stability import (
    RestingContacts,
    holds_still,
    is_stable,
)

CONTACT_GAP = 0.0015
MAX_TRIANGLES = 20_000
_DENSITY = 1000.0  # of any material: the balance of one body does not depend on it

_solids: weakref.WeakKeyDictionary[Shape, SolidBody] = weakref.WeakKeyDictionary()


def can_tell(body: Body, other: Body) -> bool:
    """Whether both bodies have watertight meshes that are not too large for a check."""
    meshes = (body.shape.mesh, other.shape.mesh)
    return all(mesh is not None and len(mesh.triangles) <= MAX_TRIANGLES for mesh in meshes)


def stays(body: Body, other: Body, table_height: float) -> bool:
    """Whether friction of 0.5 holds a body at rest on the table and on another one.

    Also on a table that is tilted by 4 degrees, which leaves out what would fall at a touch.
    Surfaces nearer than 1.5 mm touch: poses from trackers are not better than that. The other
    body must bear the load without tipping, if it stands at all without it: one whose pose is
    off the table, or that something else holds, is taken as fixed.
    """
    placed, fixed = _placed(body, table_height), _placed(other, table_height)
    on_table = table_contacts(placed, gap=CONTACT_GAP)
    between = find_contacts(fixed, placed, gap=CONTACT_GAP)
    if not holds_still(placed, [on_table, between]):
        return False
    below_other = table_contacts(fixed, gap=CONTACT_GAP)
    if not holds_still(fixed, [below_other]):
        return True
    return is_stable(fixed, placed, RestingContacts(below_other, on_table, between))


def _placed(body: Body, table_height: float) -> Placed:
    """The body for the generator's checks, whose table is at z = 0."""
    solid, centre = _solid(body.shape)
    rotation = body.pose.rotation
    translation = body.pose.apply(centre) - np.array([0.0, 0.0, table_height])
    return Placed(solid, rotation, translation)


def _solid(shape: Shape) -> tuple[SolidBody, np.ndarray]:
    """The solid with its bounding box around the origin, and where that box was."""
    mesh = shape.mesh
    if mesh is None:
        raise ValueError('a cloud alone has no surface to balance on')
    vertices = mesh.vertices.astype(np.float64)
    centre = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    if shape not in _solids:
        centred = TriangleMesh((vertices - centre).astype(np.float32), mesh.triangles)
        model = ObjectModel('', '', centred, {}, None, _DENSITY)
        _solids[shape] = SolidBody.of(model)
    return _solids[shape], centre
