"""How far a body is from the ways in which it rests on level ground."""

from __future__ import annotations

import numpy as np

from spatial_relations_ros.placement.body import Placed

_LEAST_MARGIN = 0.002


def lean_angle_rad(placed: Placed, *, least_margin: float = _LEAST_MARGIN) -> float:
    """Angle to the nearest orientation in which the body stands on level ground, radians.

    Args:
        placed: the body.
        least_margin: orientations on footprints that leave the centre of mass less are not
            counted, metres.
    """
    poses = placed.body.model.rest_poses
    steady = [pose for pose in poses if pose.margin > least_margin] or list(poses)
    if not steady:  # too small for any to be found
        return 0.0
    ups = np.array([pose.rotation[2] for pose in steady])
    cosine = float((ups @ placed.rotation[2]).max())
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))
