"""How an object stands: by how much it leans, and how far it was turned over."""

from __future__ import annotations

import math

from spatial_relations_ros.core import Scene
from spatial_relations_ros.imitation.shape import shape_of
from spatial_relations_ros.imitation.solids import hand_scale, solid_of
from spatial_relations_ros.placement.body import Placed
from spatial_relations_ros.placement.leaning import lean_angle_rad

_MOST_DIFFERENT_RAD = math.radians(40.0)


def demonstrated_lean(reference: Scene) -> float | None:
    """Angle of the relative to the nearest way in which it rests, radians; None without a mesh.

    Of a cloud it would have to be guessed with the solid.
    """
    if reference.relative.mesh is None:
        return None
    shape = shape_of(reference.relative)
    solid = solid_of(shape, hand_scale((shape,)))
    return lean_angle_rad(solid.placed(reference.relative.world_from_object, (0.0, 0.0, 0.0)))


def lean_difference(placed: Placed, wanted_rad: float) -> float:
    """How far a body's lean is from another one, 0 to 1."""
    return min(abs(lean_angle_rad(placed) - wanted_rad) / _MOST_DIFFERENT_RAD, 1.0)


def turned_over(before: Placed, after: Placed) -> float:
    """How far the direction that points up in the body has turned: 0, or 1 for upside down."""
    cosine = float(before.rotation[2] @ after.rotation[2])
    return math.acos(max(-1.0, min(1.0, cosine))) / math.pi
