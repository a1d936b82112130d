"""Scenes next to each other and on top of each other."""

from __future__ import annotations

import numpy as np

from spatial_relations_ros.placement.body import FloatArray, Placed
from spatial_relations_ros.placement.footing import (
    CENTRED_SHARE,
    INNER_MARGIN_OF_SUPPORT,
    LEAST_OVERHANG_OF_FOOT,
)
from spatial_relations_ros.placement.resting import (
    about_z,
    above,
    centred,
    dropped,
    half_width,
    horizontal,
    pushed,
    random_direction,
    side_direction,
)

MAX_GAP = 0.20
_TYPICAL_GAP = 0.05
_TOUCHING_SHARE = 0.12
_TOP_BAND = 0.002
_NARROW_TOP = 0.025
_NARROW_TOP_SHARE = 0.3


def place_next_to(fixed: Placed, moving: Placed, rng: np.random.Generator) -> Placed | str:
    """Both stand on the table: touching, or apart by up to 20 cm, mostly a few centimetres."""
    direction = random_direction(rng)
    sideways = np.array([-direction[1], direction[0], 0.0])
    lateral = rng.uniform(-0.5, 0.5) * max(
        half_width(fixed, sideways), half_width(moving, sideways)
    )
    start = -direction * (fixed.body.radius + moving.body.radius + 0.1) + sideways * lateral
    touching = pushed(moving.moved(start), fixed, direction)
    if touching is None:
        return 'passes the base'
    gap = min(0.002 + rng.exponential(_TYPICAL_GAP), MAX_GAP)
    if rng.random() < _TOUCHING_SHARE:
        gap = rng.uniform(0.0002, 0.002)
    return touching.moved(-direction * gap)


def top_region(placed: Placed) -> tuple[FloatArray, FloatArray]:
    """Centre (2,) and points (N, 2) of a body's highest level."""
    vertices = placed.world_points
    top = vertices[vertices[:, 2] > vertices[:, 2].max() - _TOP_BAND, :2]
    return 0.5 * (top.min(axis=0) + top.max(axis=0)), top


def bottom_region(placed: Placed) -> FloatArray:
    """Points (N, 2) of a body's lowest level."""
    vertices = placed.world_points
    return np.asarray(vertices[vertices[:, 2] < vertices[:, 2].min() + _TOP_BAND, :2])


def place_on_top(fixed: Placed, moving: Placed, rng: np.random.Generator) -> Placed | str:
    """The relative stands well within the base's top, or centred where it is the larger one."""
    centre, top = top_region(fixed)
    direction = random_direction(rng)[:2]
    base_half = _half(top, direction)
    if base_half < _NARROW_TOP and rng.random() > _NARROW_TOP_SHARE:
        return 'narrow top'
    if base_half < 0.010:
        return 'top too small'
    foot_half = _half(bottom_region(moving), direction)
    # What is on the bases' border is left out, and where the foot is large only its middle is in.
    inner = base_half * (1.0 - 2.0 * INNER_MARGIN_OF_SUPPORT) - foot_half - 0.005
    largest = max(inner, 2.0 * CENTRED_SHARE * min(base_half, foot_half))
    offset = np.sqrt(rng.random()) * largest * direction
    foot = bottom_region(moving)
    to_foot = 0.5 * (foot.min(axis=0) + foot.max(axis=0)) - _middle(moving)
    return dropped(above(moving, fixed, centre + offset - to_foot), fixed)


def place_on_edge(fixed: Placed, moving: Placed, rng: np.random.Generator) -> Placed | str:
    """The relative stands on the border or a corner of the base and clearly reaches over it."""
    centre, top = top_region(fixed)
    direction = side_direction(fixed, rng)[:2]
    if rng.random() < 0.3:  # towards a corner
        turn = horizontal(np.pi / 4.0 + rng.normal(0.0, 0.1))
        direction = about_z(np.arctan2(turn[1], turn[0]))[:2, :2] @ direction
    base_reach = support_width(top, centre, direction)
    moving = moving.turned(about_z(rng.uniform(0.0, 2.0 * np.pi)))
    moving = centred(moving, np.append(centre, 0.0), bottom=0.0)
    foot = bottom_region(moving)
    foot_width = 2.0 * _half(foot, direction)
    if base_reach < 0.02 or foot_width < 0.02:
        return 'top too small'
    # The share of the foot that hangs over; the base must stay under the centre of mass.
    overhang = rng.uniform(LEAST_OVERHANG_OF_FOOT + 0.01, 0.48)
    shift = base_reach - support_width(foot, centre, direction) + overhang * foot_width
    along = np.array([-direction[1], direction[0]])
    slide = rng.normal(0.0, 0.15) * _half(top, along)
    moving = above(moving, fixed, centre + shift * direction + slide * along)
    return dropped(moving, fixed)


def support_width(points: FloatArray, centre: FloatArray, direction: FloatArray) -> float:
    """Reach of points (N, 2) beyond a centre (2,) along a direction (2,), metres."""
    return float(((points - centre) @ direction).max())


def _half(points: FloatArray, direction: FloatArray) -> float:
    """Half of the extent of points (N, 2) along a direction (2,), metres."""
    return float(np.ptp(points @ direction)) / 2.0


def _middle(placed: Placed) -> FloatArray:
    """Middle (2,) of a body's bounding box seen from above."""
    vertices = placed.world_vertices[:, :2]
    return np.asarray(0.5 * (vertices.min(axis=0) + vertices.max(axis=0)))
