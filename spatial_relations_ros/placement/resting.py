"""Choosing how a body rests, and the vertical and horizontal moves until contact."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from spatial_relations_ros.placement.body import Body, FloatArray, Placed
from spatial_relations_ros.placement.contact import travel_to_contact
from spatial_relations_ros.placement.rest_poses import RestKind, RestPose

Ways = Mapping[RestKind, float]
# Places a standing body around a fixed one at x = y = 0 on the table z = 0, or says why it cannot.
PlacingRule = Callable[[Placed, Placed, np.random.Generator], Placed | str]

# How often people use each way up; measured on the poses of human-made scenes.
BASE_WAYS: Ways = {
    RestKind.UPRIGHT: 0.69,
    RestKind.SIDE: 0.23,
    RestKind.UPSIDE_DOWN: 0.08,
}
RELATIVE_WAYS: Ways = {
    RestKind.UPRIGHT: 0.62,
    RestKind.SIDE: 0.33,
    RestKind.UPSIDE_DOWN: 0.05,
}
# Beside and on what lies, people lay more.
RELATIVE_WAYS_WHERE_BASE_LIES: Ways = {
    RestKind.UPRIGHT: 0.40,
    RestKind.SIDE: 0.55,
    RestKind.UPSIDE_DOWN: 0.05,
}
LEANING_WAYS: Ways = {
    RestKind.UPRIGHT: 0.45,
    RestKind.SIDE: 0.45,
    RestKind.UPSIDE_DOWN: 0.10,
}
UPRIGHT_ONLY: Ways = {RestKind.UPRIGHT: 1.0}
SIDE_ONLY: Ways = {RestKind.SIDE: 1.0}

_MIN_TIPPING_ANGLE = np.deg2rad(7.0)
_SLANT = np.deg2rad(14.0)
_SLANTING_SHARE = 0.2
UP = np.array([0.0, 0.0, 1.0])
DOWN = -UP


def about_z(angle_rad: float) -> FloatArray:
    """Rotation (3, 3) about the world's z axis."""
    cosine, sine = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def about_axis(axis: FloatArray, angle_rad: float) -> FloatArray:
    """Rotation (3, 3) about a unit axis (3,), by Rodrigues' formula."""
    skew = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    rotation: FloatArray = (
        np.eye(3) + np.sin(angle_rad) * skew + (1.0 - np.cos(angle_rad)) * skew @ skew
    )
    return rotation


def horizontal(angle_rad: float) -> FloatArray:
    """Horizontal unit vector (3,)."""
    return np.array([np.cos(angle_rad), np.sin(angle_rad), 0.0])


def random_direction(rng: np.random.Generator) -> FloatArray:
    """Horizontal unit vector (3,), all directions alike."""
    return horizontal(rng.uniform(0.0, 2.0 * np.pi))


def sample_rest_pose(body: Body, weights: Ways, rng: np.random.Generator) -> RestPose | None:
    """Draws how a body rests; None when it rests in none of the wanted ways.

    People do not balance things on small feet: poses that fall when tilted by a few degrees are
    left out, unless the axis is level (a can may roll, yet it is laid down).
    """
    by_kind: dict[RestKind, list[RestPose]] = {}
    for pose in body.model.rest_poses:
        lies = abs(pose.rotation[2, 2]) < np.sin(_SLANT)
        is_steady = pose.tipping_angle_rad > _MIN_TIPPING_ANGLE or lies
        if weights.get(pose.kind, 0.0) > 0.0 and is_steady:
            by_kind.setdefault(pose.kind, []).append(pose)
    if not by_kind:
        return None
    kinds = list(by_kind)
    shares = np.array([weights[kind] for kind in kinds])
    poses = by_kind[kinds[rng.choice(len(kinds), p=shares / shares.sum())]]
    # Wide footprints are likelier, yet a cereal box is also laid on its narrow side.
    margins = np.array([(pose.margin + 2e-3) * _likelihood(pose) for pose in poses])
    return poses[rng.choice(len(poses), p=margins / margins.sum())]


def _likelihood(pose: RestPose) -> float:
    """People rarely leave things on a slanting side."""
    level = abs(pose.rotation[2, 2])
    is_slanting = np.sin(_SLANT) < level < np.cos(_SLANT)
    return _SLANTING_SHARE if is_slanting else 1.0


def rest_on_table(body: Body, weights: Ways, rng: np.random.Generator) -> Placed | None:
    """A body that rests on the table z = 0 at the origin, at a random heading."""
    pose = sample_rest_pose(body, weights, rng)
    if pose is None:
        return None
    rotation = about_z(rng.uniform(0.0, 2.0 * np.pi)) @ pose.rotation
    return Placed(body, rotation, np.zeros(3)).on_table()


def faced(placed: Placed, direction: FloatArray, rng: np.random.Generator) -> Placed:
    """Turns a body about z so that one of its sides faces a direction (3,), roughly."""
    axes = placed.rotation[:2] / np.maximum(np.linalg.norm(placed.rotation[:2], axis=0), 1e-9)
    level = np.flatnonzero(np.abs(placed.rotation[2]) < 0.75)
    axis = axes[:, rng.choice(level)]
    heading = np.arctan2(axis[1], axis[0]) + np.pi * rng.integers(2)
    wanted = np.arctan2(direction[1], direction[0])
    return placed.turned(about_z(wanted - heading + rng.normal(0.0, 0.03)))


def side_direction(placed: Placed, rng: np.random.Generator) -> FloatArray:
    """A horizontal direction (3,): of one of the body's sides, roughly, or any."""
    if rng.random() < 0.35:
        return random_direction(rng)
    level = np.flatnonzero(np.abs(placed.rotation[2]) < 0.75)
    axis = placed.rotation[:2, rng.choice(level)]
    heading = np.arctan2(axis[1], axis[0]) + np.pi * rng.integers(2)
    return horizontal(heading + rng.normal(0.0, 0.05))


def half_width(placed: Placed, direction: FloatArray) -> float:
    """Half of a body's extent along a unit direction (3,), metres."""
    along = placed.world_vertices @ direction
    return float(along.max() - along.min()) / 2.0


def centred(placed: Placed, centre: FloatArray, *, bottom: float) -> Placed:
    """Moves the middle of a body's bounding box over a point (x, y, ...), lowest point at z."""
    vertices = placed.world_vertices
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middle = 0.5 * (low + high)
    return placed.moved(np.array([centre[0] - middle[0], centre[1] - middle[1], bottom - low[2]]))


def dropped(moving: Placed, fixed: Placed) -> Placed:
    """Lowers a body straight until it first touches another body or the table."""
    to_table = float(moving.world_vertices[:, 2].min())
    return moving.moved(DOWN * min(travel_to_contact(moving, fixed, DOWN), to_table))


def above(moving: Placed, fixed: Placed, centre: FloatArray) -> Placed:
    """Places a body over a point, just above the highest point of another."""
    top = float(fixed.world_vertices[:, 2].max())
    return centred(moving, centre, bottom=top + 0.005)


def pushed(moving: Placed, fixed: Placed, direction: FloatArray) -> Placed | None:
    """Pushes a body along a horizontal direction until it touches another; None if it passes."""
    travel = travel_to_contact(moving, fixed, direction)
    return moving.moved(direction * travel) if np.isfinite(travel) else None
