"""Whether a placement is physically possible."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from spatial_relations_ros.imitation import statics
from spatial_relations_ros.imitation.contact import Body, overlap, reach_through

MAX_PENETRATION = 0.005
CONTACT_TOLERANCE = 0.002
BALANCE_TOLERANCE = 0.002


@dataclass(frozen=True)
class PlacementCheck:
    """What geometry says about one body's place.

    Attributes:
        penetration: deepest overlap with the other body or the table, metres.
        supported: whether contacts carry the centre of mass.
        violations: in words.
    """

    penetration: float
    supported: bool
    violations: tuple[str, ...]


def overlap_depth(body: Body, other: Body) -> float:
    """How far two bodies overlap, thin walls that cross included, metres."""
    depth = overlap(body, other)
    return depth if depth > MAX_PENETRATION else max(depth, reach_through(body, other))


def check_placement(
    name: str,
    body: Body,
    other_name: str,
    other: Body,
    table_height: float,
    *,
    depth: float | None = None,
) -> PlacementCheck:
    """Checks overlap, table and support of a body beside another one.

    Penetration is measured at 2,048 surface points of each body and along the edges of its mesh;
    up to 5 mm are allowed. Of a body with a mesh on another one with a mesh friction must hold
    the weight; with a cloud alone its centre of mass must lie over the hull of its contacts.

    Args:
        name: of the body, for the words.
        body: to check.
        other_name: of the other one.
        other: what stands beside it.
        table_height: in the world, metres.
        depth: :func:`overlap_depth` of both, where it is known already.
    """
    estimate = ' (estimated from a cloud)' if _is_estimate(body, other) else ''
    depth = overlap_depth(body, other) if depth is None else depth
    below = max(table_height - float(body.world_points[:, 2].min()), 0.0)
    violations = []
    if depth > MAX_PENETRATION:
        violations.append(f'{name} would overlap {other_name} by {depth * 1e3:.0f} mm{estimate}')
    if below > MAX_PENETRATION:
        violations.append(f'{name} would be {below * 1e3:.0f} mm below the table')
    problem = _support_problem(name, body, other, table_height)
    if problem:
        violations.append(problem + estimate)
    return PlacementCheck(max(depth, below), not problem, tuple(violations))


def is_supported(body: Body, other: Body, table_height: float) -> bool:
    """Whether a body stays where it is, beside or on another one that is fixed."""
    return not _support_problem('', body, other, table_height)


def _is_estimate(body: Body, other: Body) -> bool:
    return body.shape.is_estimate or other.shape.is_estimate


def _support_problem(name: str, body: Body, other: Body, table_height: float) -> str:
    contacts = contact_points(body, other, table_height)
    if not len(contacts):
        gap = float(body.world_points[:, 2].min()) - table_height
        return f'{name} would hang {gap * 1e3:.0f} mm above the table and touch nothing'
    if not _is_estimate(body, other):
        if statics.stays(body, other, table_height):
            return ''
        return f'{name} would not stay: friction does not hold it there'
    centre = body.world_centre_of_mass[:2]
    outside = distance_to_hull(contacts[:, :2], centre)
    if outside > BALANCE_TOLERANCE:
        return f'{name} would tip: its centre of mass is {outside * 1e3:.0f} mm off its support'
    return ''


def contact_points(body: Body, other: Body, table_height: float) -> NDArray[np.float64]:
    """World points (C, 3) where a body touches the table or the other body."""
    tolerance = CONTACT_TOLERANCE
    if _is_estimate(body, other):
        tolerance += max(body.shape.field.spacing, other.shape.field.spacing)
    points, other_points = body.world_points, other.world_points
    touches = (points[:, 2] - table_height < tolerance) | _at_surface(other, points, tolerance)
    touched = _at_surface(body, other_points, tolerance)
    return np.concatenate([points[touches], other_points[touched]])


def _at_surface(
    body: Body, world_points: NDArray[np.float64], tolerance: float
) -> NDArray[np.bool_]:
    """Which points (N, 3) are within a tolerance of a body's surface."""
    field = body.shape.field
    local = torch.from_numpy(body.pose.inverse().apply(world_points).astype(np.float32))
    # Between its nodes the grid is off by less than its spacing: only what is left is measured.
    near = np.abs(field.sample(local).numpy()) < tolerance + field.spacing
    near[near] = np.abs(body.signed_distance(world_points[near])) < tolerance
    return np.asarray(near)


def distance_to_hull(points: NDArray[np.float64], query: NDArray[np.float64]) -> float:
    """Metres from a query (2,) to the convex hull of points (N, 2); 0 inside."""
    try:
        corners = points[ConvexHull(points).vertices] if len(points) > 2 else points
    except QhullError:  # all points on a line
        order = np.argsort(points @ np.ptp(points, axis=0))
        corners = points[order[[0, -1]]]
    following = np.roll(corners, -1, axis=0)
    edge, to_query = following - corners, query - corners
    cross = edge[:, 0] * to_query[:, 1] - edge[:, 1] * to_query[:, 0]
    if len(corners) > 2 and (cross >= 0.0).all():
        return 0.0
    squared = np.maximum((edge**2).sum(axis=1), 1e-18)
    share = np.clip((edge * to_query).sum(axis=1) / squared, 0.0, 1.0)
    nearest = corners + share[:, None] * edge
    return float(np.linalg.norm(query - nearest, axis=1).min())
