"""In which ways an object may stand before it is placed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.placement.body import Body, Placed
from spatial_relations_ros.placement.rest_poses import RestPose, rotation_between
from spatial_relations_ros.placement.resting import UP

FloatArray = NDArray[np.float64]

_AT_REST_RAD = math.radians(5.0)
_STEADY_RAD = math.radians(4.0)
_MAX_ORIENTATIONS = 4
_SAME_EXTENT = 0.03


def resting_orientations(body: Body, current: FloatArray) -> list[FloatArray]:
    """Orientations (3, 3) in which a body rests, the current one first, unlike each other.

    Args:
        body: the body.
        current: (3, 3) as it is now; made level where it nearly rests, else it is kept as the
            first one all the same: a tracked pose is never exact.
    """
    poses = [p for p in body.model.rest_poses if p.tipping_angle_rad > _STEADY_RAD]
    poses = poses or list(body.model.rest_poses)
    kept: list[FloatArray] = [_levelled(poses, current)]
    for pose in sorted(poses, key=_likelihood, reverse=True):
        if len(kept) == _MAX_ORIENTATIONS:
            break
        if not any(_looks_alike(body, pose.rotation, other) for other in kept):
            kept.append(pose.rotation)
    return kept


def standing_bases(base: Placed, *, upright: bool) -> list[Placed]:
    """The base on the table at its place, in the ways in which it rests."""
    orientations = resting_orientations(base.body, base.rotation)
    orientations = orientations[:1] if upright else orientations
    level = base.translation * [1.0, 1.0, 0.0]
    return [Placed(base.body, rotation, level).on_table() for rotation in orientations]


def _levelled(poses: Sequence[RestPose], current: FloatArray) -> FloatArray:
    if not poses:
        return current
    ups = np.array([pose.rotation[2] for pose in poses]) @ current.T
    nearest = int(ups[:, 2].argmax())
    if math.acos(min(1.0, float(ups[nearest, 2]))) > _AT_REST_RAD:
        return current
    return np.asarray(rotation_between(ups[nearest], UP) @ current)


def _likelihood(pose: RestPose) -> float:
    """Objects stand rather square to their frame than on a slanting side."""
    return pose.margin * float(np.abs(pose.rotation[2]).max()) ** 4


def _looks_alike(body: Body, first: FloatArray, second: FloatArray) -> bool:
    """Whether a body turned one way and the other has the same heights and mass heights."""
    vertices = body.model.mesh.vertices
    heights = [vertices @ rotation[2] for rotation in (first, second)]
    spans = [float(np.ptp(height)) for height in heights]
    centres = [
        float(body.model.mass_properties.centre @ rotation[2] - height.min())
        for rotation, height in zip((first, second), heights, strict=True)
    ]
    tolerance = _SAME_EXTENT * max(spans)
    if abs(spans[0] - spans[1]) > tolerance or abs(centres[0] - centres[1]) > tolerance:
        return False
    # A flat thing lies on either side alike; what opens to one side does not.
    opening = body.model.opening
    return opening is None or abs(first[2, 2] - second[2, 2]) < 0.3
