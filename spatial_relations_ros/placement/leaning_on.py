"""Scenes in which the relative leans: on the base's side, or in it on its rim."""

from __future__ import annotations

import numpy as np

from spatial_relations_ros.placement.body import FloatArray, Placed
from spatial_relations_ros.placement.contact import first_contact
from spatial_relations_ros.placement.resting import (
    DOWN,
    about_axis,
    above,
    centred,
    faced,
    half_width,
    pushed,
    random_direction,
    side_direction,
)

_LEAST_LEAN = float(np.deg2rad(13.0))
_MOST_LIFT = float(np.deg2rad(75.0))
_NUM_DROPS = 9
_FOOT_HEIGHT = 0.02
_LEAST_SHARE_INSIDE = 0.35
_BELOW_RIM_SHARE = 0.5


def place_inclined(fixed: Placed, standing: Placed, rng: np.random.Generator) -> Placed | str:
    """One edge of the relative stands on the table, the other end lies against the base."""
    direction = side_direction(fixed, rng)
    if rng.random() < 0.75:
        standing = faced(standing, direction, rng)
    support = float(fixed.world_vertices[:, 2].max())
    tilted = tilt(standing, direction, _lean_angle(standing, direction, support, rng))
    tilted = centred(tilted, np.zeros(3), bottom=0.0)
    vertices = tilted.world_vertices
    foot = vertices[vertices[:, 2].argmin()] @ direction
    if tilted.centre_of_mass() @ direction < foot + 0.003:
        return 'falls away from the base'
    sideways = np.array([-direction[1], direction[0], 0.0])
    lateral = rng.uniform(-0.45, 0.45) * half_width(fixed, sideways)
    if rng.random() < 0.5:
        lateral *= 0.1  # against the middle: the only way with round bases
    start = -direction * (fixed.body.radius + standing.body.radius + 0.05) + sideways * lateral
    touching = pushed(tilted.moved(start), fixed, direction)
    if touching is None:
        return 'passes the base'
    return touching


def _lean_angle(
    standing: Placed, direction: FloatArray, support: float, rng: np.random.Generator
) -> float:
    """Signed tilt: positive turns the top towards the base, negative lifts the near side.

    What is lifted is lifted over a support of a height (metres), if it is long enough.
    """
    height = float(standing.world_vertices[:, 2].max())
    width = 2.0 * half_width(standing, direction)
    if height < 0.8 * width or (height < 1.2 * width and rng.random() < 0.5):
        least = _LEAST_LEAN
        if 0.0 < support < 0.9 * width:
            least = max(least, float(np.arcsin(1.05 * support / width)))
        return -min(least + rng.uniform(0.0, np.deg2rad(16.0)), _MOST_LIFT)
    return float(rng.triangular(_LEAST_LEAN, np.deg2rad(18.0), np.deg2rad(48.0)))


def tilt(placed: Placed, direction: FloatArray, angle_rad: float) -> Placed:
    """Turns a body's top towards a horizontal direction (3,)."""
    axis = np.array([-direction[1], direction[0], 0.0])
    return placed.turned(about_axis(axis, angle_rad))


def place_inside_inclined(
    fixed: Placed, standing: Placed, rng: np.random.Generator
) -> Placed | str:
    """A long relative stands in an upright container and leans on its rim or wall."""
    opening = fixed.body.model.opening
    if opening is None or not fixed.body.model.is_container:
        return 'base holds nothing'
    direction = random_direction(rng) if opening.is_round else side_direction(fixed, rng)
    if rng.random() < 0.75:
        standing = faced(standing, direction, rng)
    tilted = tilt(standing, direction, _lean_angle(standing, direction, opening.depth, rng))
    # What is below the rim when the lowest point is on the floor must fit through the opening.
    vertices = tilted.world_vertices
    sunk = vertices[vertices[:, 2] < vertices[:, 2].min() + opening.depth]
    if np.ptp(sunk @ direction) > 2.1 * max(opening.rim_half_size):
        return 'does not fit'
    centre = fixed.rotation @ [*opening.centre, 0.0] + fixed.translation
    if float(np.ptp(vertices[:, 2])) < opening.depth + 0.008:
        if rng.random() > _BELOW_RIM_SHARE:
            return 'below the rim'
        return _lean_on_wall(fixed, tilted, direction, centre=centre, rng=rng)
    rim = float(fixed.translation[2] + opening.rim_z)
    floor_limit = rim - _LEAST_SHARE_INSIDE * opening.depth
    return _slide_to_rim(fixed, tilted, direction, centre=centre, floor_limit=floor_limit)


def settle_in_rim(fixed: Placed, tilted: Placed, direction: FloatArray) -> Placed | str:
    """Lets a tilted body down into an upright container until it leans on its rim or wall.

    Args:
        fixed: the container.
        tilted: in it, or near; its tilt and its place across the direction are kept.
        direction: (3,) horizontal unit vector from its foot towards where it leans.
    """
    opening = fixed.body.model.opening
    if opening is None:
        return 'base holds nothing'
    vertices = tilted.world_vertices
    centre = fixed.rotation @ [*opening.centre, 0.0] + fixed.translation
    sideways = np.array([-direction[1], direction[0], 0.0])
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    if float(np.ptp(vertices[:, 2])) < opening.depth + 0.008:
        landed, _ = _drop(above(tilted, fixed, middle), fixed, np.inf)
        return _pushed_to_wall(landed, fixed, direction)
    centre = centre + ((middle - centre) @ sideways) * sideways
    rim = float(fixed.translation[2] + opening.rim_z)
    floor_limit = rim - _LEAST_SHARE_INSIDE * opening.depth
    return _slide_to_rim(fixed, tilted, direction, centre=centre, floor_limit=floor_limit)


def _pushed_to_wall(inside: Placed, fixed: Placed, direction: FloatArray) -> Placed | str:
    """Pushes a body that stands in a container against its wall."""
    raised = inside.moved(np.array([0.0, 0.0, 2e-4]))
    touching = pushed(raised, fixed, direction)
    if touching is None:
        return 'passes over the rim'
    return _drop(touching.moved(-2e-4 * direction), fixed, np.inf)[0]


def _lean_on_wall(
    fixed: Placed,
    tilted: Placed,
    direction: FloatArray,
    *,
    centre: FloatArray,
    rng: np.random.Generator,
) -> Placed | str:
    """Sets a body that does not reach the rim on the floor and pushes it against the wall."""
    opening = fixed.body.model.opening
    assert opening is not None
    sideways = np.array([-direction[1], direction[0], 0.0])
    room = min(opening.floor_half_size) - half_width(tilted, sideways)
    if room < 0.0 or half_width(tilted, direction) > min(opening.rim_half_size):
        return 'does not fit'
    lateral = rng.uniform(-0.7, 0.7) * room * sideways
    inside, _ = _drop(above(tilted, fixed, centre + lateral), fixed, np.inf)
    if inside.world_vertices[:, 2].min() > fixed.translation[2] + opening.floor_z + 0.01:
        return 'does not reach the floor'
    return _pushed_to_wall(inside, fixed, direction)


def _slide_to_rim(
    fixed: Placed, tilted: Placed, direction: FloatArray, *, centre: FloatArray, floor_limit: float
) -> Placed | str:
    """Finds where a tilted body touches with its foot and with its upper part at once.

    Dropped near the far wall it lands on its foot; dropped further along the direction it lands
    on the rim. Between the two places it leans: found by bisection.
    """
    reach = half_width(fixed, direction)
    start = above(tilted, fixed, centre)
    vertices = start.world_vertices
    foot = vertices[vertices[:, 2].argmin()]
    start = start.moved(-((foot - centre) @ direction) * direction)
    coarse, on_foot = start.coarse(), None
    step = 2.0 * reach / _NUM_DROPS
    for shift in np.arange(_NUM_DROPS) * step - reach:
        _, lands_on_foot = _drop(coarse.moved(shift * direction), fixed.coarse(), floor_limit)
        if lands_on_foot:
            on_foot = shift
        elif on_foot is not None:
            break
    else:
        return 'does not reach the floor' if on_foot is None else 'passes over the rim'
    too_far = on_foot + step
    while too_far - on_foot > 3e-4:
        middle = 0.5 * (on_foot + too_far)
        if _drop(start.moved(middle * direction), fixed, floor_limit)[1]:
            on_foot = middle
        else:
            too_far = middle
    landed, _ = _drop(start.moved(on_foot * direction), fixed, floor_limit)
    return landed


def _drop(moving: Placed, fixed: Placed, floor_limit: float) -> tuple[Placed, bool]:
    """Lowers a body until it touches, and whether with its lowest part, in it."""
    travel, point = first_contact(moving, fixed, DOWN)
    to_table = float(moving.world_vertices[:, 2].min())
    landed = moving.moved(DOWN * min(travel, to_table))
    lowest = to_table - min(travel, to_table)
    highest_foot = min(lowest + _FOOT_HEIGHT, floor_limit)
    return landed, travel <= to_table and point[2] < highest_foot
