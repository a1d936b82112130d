"""How far a body is from the ways in which it rests on level ground."""

from __future__ import annotations

import numpy as np

from spatial_relations_ros.placement.body import Placed


def lean_angle_rad(placed: Placed) -> float:
    """Angle to the nearest orientation in which the body stays on level ground, radians.

    However narrow its footprint there is: a can on its side lies on a strip and does not lean.
    """
    ups = placed.body.model.level_axes
    if not len(ups):  # too small for any to be found
        return 0.0
    cosine = float((ups @ placed.rotation[2]).max())
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))
