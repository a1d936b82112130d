"""Scenes in which the relative is inside: upright, or in a container that lies."""

from __future__ import annotations

import numpy as np

from spatial_relations_ros.placement.body import FloatArray, Placed
from spatial_relations_ros.placement.contact import is_clear, travel_to_contact
from spatial_relations_ros.placement.ray_casting import as_tensor
from spatial_relations_ros.placement.resting import (
    DOWN,
    about_axis,
    about_z,
    above,
    centred,
    dropped,
    half_width,
)


def place_inside(fixed: Placed, moving: Placed, rng: np.random.Generator) -> Placed | str:
    """The relative stands (or lies) level on the floor of an upright container."""
    opening = fixed.body.model.opening
    if opening is None or not fixed.body.model.is_container:
        return 'base holds nothing'
    if not opening.is_round and rng.random() < 0.5:
        moving = _aligned(moving, fixed, rng)
    axis_x, axis_y = fixed.rotation[:, 0], fixed.rotation[:, 1]
    slack_x = min(opening.rim_half_size[0], opening.floor_half_size[0] * 1.2)
    slack_y = min(opening.rim_half_size[1], opening.floor_half_size[1] * 1.2)
    slack_x -= half_width(moving, axis_x)
    slack_y -= half_width(moving, axis_y)
    rim_slack = opening.rim_half_size[0] - half_width(moving, axis_x)
    rim_slack = min(rim_slack, opening.rim_half_size[1] - half_width(moving, axis_y))
    if rim_slack < 0.0:
        return 'does not fit'
    centre = fixed.rotation @ [*opening.centre, 0.0] + fixed.translation
    offset = axis_x * rng.uniform(-1.0, 1.0) * max(slack_x, 0.0)
    offset = offset + axis_y * rng.uniform(-1.0, 1.0) * max(slack_y, 0.0)
    return dropped(above(moving, fixed, centre + offset), fixed)


def _aligned(moving: Placed, fixed: Placed, rng: np.random.Generator) -> Placed:
    """Turns a body so that its longest horizontal side is roughly along the container's x."""
    footprint = moving.world_vertices[:, :2]
    _, axes = np.linalg.eigh(np.cov(footprint.T))
    heading = np.arctan2(axes[1, 1], axes[0, 1])
    wanted = np.arctan2(fixed.rotation[1, 0], fixed.rotation[0, 0])
    return moving.turned(about_z(wanted - heading + rng.normal(0.0, 0.08)))


def place_inside_lying(fixed: Placed, moving: Placed, rng: np.random.Generator) -> Placed | str:
    """The container lies on its side; the relative lies on its wall, in it or reaching out."""
    opening = fixed.body.model.opening
    if opening is None or not fixed.body.model.is_container:
        return 'base holds nothing'
    out = fixed.rotation[:, 2]
    if abs(out[2]) > 0.5:
        return 'opening not to the side'
    outwards = np.array([out[0], out[1], 0.0]) / np.hypot(out[0], out[1])
    moving = _facing(moving, outwards, rng)
    length = 2.0 * half_width(moving, outwards)
    depth = opening.depth
    # The inner end goes at least a third of the depth, and of its own length, into it.
    deepest = rng.uniform(max(0.35, min(0.4 * length / depth, 0.95)), 0.99) * depth
    inner = max(deepest - length, 0.0)
    middle = 0.5 * (deepest + inner)
    ground = _lower_wall(fixed, inner, deepest)
    if ground is None:
        return 'no wall below'
    moving = _pitched(moving, outwards, ground[1] - ground[0])
    return _set_down(fixed, moving, outwards, middle=middle, deepest=deepest, rng=rng)


def _facing(moving: Placed, outwards: FloatArray, rng: np.random.Generator) -> Placed:
    """Mostly turns a body's long side along the container's axis."""
    footprint = moving.world_vertices[:, :2]
    values, axes = np.linalg.eigh(np.cov(footprint.T))
    if values[1] < 1.3 * values[0] or rng.random() < 0.15:
        return moving
    heading = np.arctan2(axes[1, 1], axes[0, 1]) + np.pi * rng.integers(2)
    wanted = np.arctan2(outwards[1], outwards[0])
    return moving.turned(about_z(wanted - heading + rng.normal(0.0, 0.06)))


def _axis_point(fixed: Placed, insertion: float) -> FloatArray:
    """World point (3,) on the cavity's axis, a distance below its rim."""
    opening = fixed.body.model.opening
    assert opening is not None
    local = np.array([*opening.centre, opening.rim_z - insertion])
    return np.asarray(fixed.rotation @ local + fixed.translation)


def _lower_wall(
    fixed: Placed, inner: float, deepest: float
) -> tuple[FloatArray, FloatArray] | None:
    """Points of the lower inner wall below the cavity's axis at two insertions."""
    origins = np.stack([_axis_point(fixed, inner + 1e-3), _axis_point(fixed, deepest - 1e-3)])
    rays = np.empty((2, 6), dtype=np.float32)
    rays[:, :3] = fixed.to_object(origins)
    rays[:, 3:] = fixed.rotation.T @ DOWN
    hits = fixed.body.surface.cast_rays(as_tensor(rays))['t_hit'].numpy().astype(np.float64)
    if not np.isfinite(hits).all():
        return None
    points = origins + hits[:, None] * DOWN
    return points[0], points[1]


def _pitched(moving: Placed, outwards: FloatArray, slope: FloatArray) -> Placed:
    """Tilts a body so that its foot is parallel to the wall below it."""
    angle = np.arctan2(slope[2], -(slope @ outwards))
    sideways = np.array([-outwards[1], outwards[0], 0.0])
    return moving.turned(about_axis(sideways, angle))


def _set_down(
    fixed: Placed,
    moving: Placed,
    outwards: FloatArray,
    *,
    middle: float,
    deepest: float,
    rng: np.random.Generator,
) -> Placed | str:
    opening = fixed.body.model.opening
    assert opening is not None
    sideways = np.array([-outwards[1], outwards[0], 0.0])
    axis = _axis_point(fixed, middle)
    lateral = 0.0
    if not opening.is_round:
        room = half_width(fixed, sideways) - 0.008 - half_width(moving, sideways)
        if room < 0.0:
            return 'does not fit'
        lateral = rng.uniform(-room, room)
    placed = centred(moving, axis + lateral * sideways, bottom=0.0)
    # Along the axis: the inner end at the wanted depth.
    inner_end = float((placed.world_vertices @ outwards).min())
    wanted = float(_axis_point(fixed, deepest) @ outwards)
    placed = placed.moved((wanted - inner_end) * outwards)
    vertices = placed.world_vertices
    height = float(vertices[:, 2].max() - vertices[:, 2].min())
    placed = placed.moved(np.array([0.0, 0.0, axis[2] - 0.5 * height]))
    if not is_clear(fixed, placed, 2e-4):
        return 'does not fit'
    travel = min(travel_to_contact(placed, fixed, DOWN), float(placed.world_vertices[:, 2].min()))
    return placed.moved(DOWN * travel)
