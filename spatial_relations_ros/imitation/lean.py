"""How far an object was turned over."""

from __future__ import annotations

import math

from spatial_relations_ros.placement.body import Placed


def turned_over(before: Placed, after: Placed) -> float:
    """How far the direction that points up in the body has turned: 0, or 1 for upside down."""
    cosine = float(before.rotation[2] @ after.rotation[2])
    return math.acos(max(-1.0, min(1.0, cosine))) / math.pi
