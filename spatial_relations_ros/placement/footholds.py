"""Where a body finds a foothold on a rugged one: many places looked at at once, as height fields.

At each place the body is let down and may tilt a little. How far its centre of mass falls until
contact is a concave function of the tilt: where it falls farthest within the tilt that is allowed,
three contacts carry the body there; :mod:`..placement.tipping` finds them exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from spatial_relations_ros.placement.body import FloatArray, Placed
from spatial_relations_ros.placement.ray_casting import as_tensor

_CELLS = 28
_MAX_BASE_CELLS = 60
_NUM_PLACES = 160
_INNER_RAD, _OUTER_RAD = np.deg2rad(4.0), np.deg2rad(9.0)
_NUM_AROUND = 8
_FAR = 10.0

Floats = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Footholds:
    """Places at which a body is carried within small tilts.

    Attributes:
        offsets: (N, 2) what the body is to be moved by horizontally, metres.
        hold: (N,) how far the centre of mass rises at least when the body tilts out, as a share
            of its width; larger is steadier.
    """

    offsets: FloatArray
    hold: FloatArray


def find_footholds(moving: Placed, fixed: Placed, rng: np.random.Generator) -> Footholds:
    """Looks for footholds of a body at its orientation, anywhere over another one.

    Args:
        moving: anywhere.
        fixed: on the table z = 0.
        rng: which of the places are looked at.
    """
    low, high = _box(moving)
    fixed_low, fixed_high = _box(fixed)
    step = max(
        float((high - low)[:2].max()) / _CELLS,
        float((fixed_high - fixed_low)[:2].max()) / _MAX_BASE_CELLS,
    )
    below, corner = _field(moving, low, high, step, upwards=True)
    tops, fixed_corner = _field(fixed, fixed_low, fixed_high, step, upwards=False)
    rows, columns = below.shape
    tops = np.pad(np.where(np.isfinite(tops), tops, 0.0), ((rows, rows), (columns, columns)))
    windows = sliding_window_view(tops, below.shape)
    centre = moving.centre_of_mass()
    places = _places(tops, np.round((centre[:2] - corner) / step - 0.5), below.shape, rng)
    if not len(places):
        return Footholds(np.empty((0, 2)), np.empty(0))
    picked = windows[places[:, 0], places[:, 1]].reshape(len(places), -1)
    is_there = np.isfinite(below.ravel())
    gaps = (below.ravel()[is_there] - picked[:, is_there]).astype(np.float32)
    where = _centres(corner, below.shape, step)[is_there] - centre[:2]
    inner, outer = _rings()
    held = _lowest(gaps, where, inner).max(axis=1) - _lowest(gaps, where, outer).max(axis=1)
    kept = np.flatnonzero(held > 0.0)
    moved = fixed_corner + (places[kept] - below.shape) * step - corner
    return Footholds(moved, held[kept] / (step * _CELLS))


def _box(placed: Placed) -> tuple[FloatArray, FloatArray]:
    vertices = placed.world_vertices
    return vertices.min(axis=0), vertices.max(axis=0)


def _field(
    placed: Placed, low: FloatArray, high: FloatArray, step: float, *, upwards: bool
) -> tuple[Floats, FloatArray]:
    """Heights (R, C) at which vertical rays first meet a body, inf beside it; and the corner."""
    shape = np.ceil((high - low)[:2] / step).astype(int)
    corner = 0.5 * (low + high)[:2] - 0.5 * step * shape
    centres = _centres(corner, (int(shape[0]), int(shape[1])), step)
    start, direction = (low[2] - 1.0, 1.0) if upwards else (high[2] + 1.0, -1.0)
    rays = np.empty((len(centres), 6), dtype=np.float32)
    rays[:, :3] = placed.to_object(np.column_stack([centres, np.full(len(centres), start)]))
    rays[:, 3:] = placed.rotation.T @ [0.0, 0.0, direction]
    travel = placed.body.surface.cast_rays(as_tensor(rays))['t_hit'].numpy()
    heights = np.where(np.isfinite(travel), start + direction * travel, np.inf)
    return heights.reshape(shape), corner


def _centres(corner: FloatArray, shape: tuple[int, ...], step: float) -> FloatArray:
    rows, columns = np.indices(shape).reshape(2, -1)
    return np.asarray(corner + (np.column_stack([rows, columns]) + 0.5) * step)


def _places(
    tops: Floats, to_centre: FloatArray, shape: tuple[int, ...], rng: np.random.Generator
) -> NDArray[np.intp]:
    """Windows (K, 2) of the padded field with the centre of mass over the body or within it."""
    windows = np.argwhere(_between(tops > 0.0)) - to_centre.astype(np.intp)
    size = np.array(tops.shape) - shape
    windows = windows[((windows >= 0) & (windows <= size)).all(axis=1)]
    if len(windows) > _NUM_PLACES:
        windows = windows[rng.choice(len(windows), _NUM_PLACES, replace=False)]
    return np.asarray(windows)


def _between(is_there: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Cells that are there or lie between such, along rows or columns."""
    reached = np.zeros_like(is_there)
    for axis in (0, 1):
        before = np.logical_or.accumulate(is_there, axis=axis)
        after = np.flip(np.logical_or.accumulate(np.flip(is_there, axis), axis=axis), axis)
        reached |= before & after
    return reached


def _rings() -> tuple[Floats, Floats]:
    """Slopes (S, 2): none and small ones, and such at the limit."""
    angles = np.arange(_NUM_AROUND) * (2.0 * np.pi / _NUM_AROUND)
    around = np.stack([np.cos(angles), np.sin(angles)], axis=1).astype(np.float32)
    inner = np.concatenate([np.zeros((1, 2), np.float32), np.tan(_INNER_RAD) * around])
    return inner.astype(np.float32), (np.tan(_OUTER_RAD) * around).astype(np.float32)


def _lowest(gaps: Floats, where: FloatArray, slopes: Floats) -> Floats:
    """How far (K, S) the centre of mass falls until contact, at each place and slope."""
    planes = slopes @ where.T.astype(np.float32)
    return np.stack([(gaps - plane).min(axis=1) for plane in planes], axis=1)
