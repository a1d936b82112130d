"""Scenes next to each other and on top of each other."""

from __future__ import annotations

import numpy as np

from spatial_relations_ros.datasets.generator.body import Body, FloatArray, Placed
from spatial_relations_ros.datasets.generator.resting import (
    ANY_WAY_UP,
    about_z,
    above,
    centred,
    dropped,
    half_width,
    pushed,
    random_direction,
    rest_on_table,
)

Pair = tuple[Placed, Placed]

MAX_GAP = 0.15
_TYPICAL_GAP = 0.035
_TOP_BAND = 0.002


def place_next_to(base: Body, relative: Body, rng: np.random.Generator) -> Pair | str:
    """Both stand on the table, with a gap of up to 15 cm, mostly a few centimetres."""
    fixed = rest_on_table(base, ANY_WAY_UP, rng)
    moving = rest_on_table(relative, ANY_WAY_UP, rng)
    if fixed is None or moving is None:
        return 'no rest pose'
    direction = random_direction(rng)
    sideways = np.array([-direction[1], direction[0], 0.0])
    lateral = rng.uniform(-0.5, 0.5) * min(
        half_width(fixed, sideways), half_width(moving, sideways)
    )
    start = -direction * (base.radius + relative.radius + 0.1) + sideways * lateral
    touching = pushed(moving.moved(start), fixed, direction)
    if touching is None:
        return 'passes the base'
    gap = min(0.002 + rng.exponential(_TYPICAL_GAP), MAX_GAP)
    return fixed, touching.moved(-direction * gap)


def top_region(placed: Placed) -> tuple[FloatArray, FloatArray]:
    """Centre (2,) and points (N, 2) of a body's highest level."""
    vertices = placed.world_points
    top = vertices[vertices[:, 2] > vertices[:, 2].max() - _TOP_BAND, :2]
    return 0.5 * (top.min(axis=0) + top.max(axis=0)), top


def bottom_region(placed: Placed) -> FloatArray:
    """Points (N, 2) of a body's lowest level."""
    vertices = placed.world_points
    return np.asarray(vertices[vertices[:, 2] < vertices[:, 2].min() + _TOP_BAND, :2])


def place_on_top(base: Body, relative: Body, rng: np.random.Generator) -> Pair | str:
    """The relative stands on the base, well supported, at most a little off the middle."""
    fixed = rest_on_table(base, ANY_WAY_UP, rng)
    moving = rest_on_table(relative, ANY_WAY_UP, rng)
    if fixed is None or moving is None:
        return 'no rest pose'
    centre, top = top_region(fixed)
    direction = random_direction(rng)[:2]
    base_half = support_width(top, centre, direction)
    relative_half = half_width(moving, np.append(direction, 0.0))
    if base_half < 0.015:
        return 'top too small'
    # Up to 60 % of the way at which an overhang begins; slightly off when it is the larger one.
    largest = max(0.6 * (base_half - relative_half), 0.15 * min(base_half, relative_half))
    offset = np.sqrt(rng.random()) * largest * direction
    moving = dropped(above(moving, fixed, centre + offset), fixed)
    return fixed, moving


def place_on_edge(base: Body, relative: Body, rng: np.random.Generator) -> Pair | str:
    """The relative stands on the border of the base and clearly reaches over it."""
    fixed = rest_on_table(base, ANY_WAY_UP, rng)
    moving = rest_on_table(relative, ANY_WAY_UP, rng)
    if fixed is None or moving is None:
        return 'no rest pose'
    centre, top = top_region(fixed)
    direction = random_direction(rng)[:2]
    base_half = support_width(top, centre, direction)
    moving = centred(moving, np.append(centre, 0.0), bottom=0.0)
    foot = bottom_region(moving)
    foot_half = support_width(foot, centre, direction)
    if base_half < 0.02 or foot_half < 0.01:
        return 'top too small'
    # The share of the foot that hangs over; the base must stay under the centre of mass.
    overhang = rng.uniform(0.15, 0.46)
    offset = base_half - foot_half + 2.0 * overhang * foot_half
    # On something much smaller, or by a small part of its own size, it would look centred.
    if offset < max(0.45 * base_half, 0.3 * foot_half):
        return 'relative too large'
    turn = about_z(rng.uniform(0.0, 2.0 * np.pi))
    moving = above(moving.turned(turn), fixed, centre + offset * direction)
    return fixed, dropped(moving, fixed)


def support_width(points: FloatArray, centre: FloatArray, direction: FloatArray) -> float:
    """Reach of points (N, 2) beyond a centre (2,) along a direction (2,), metres."""
    return float(((points - centre) @ direction).max())
