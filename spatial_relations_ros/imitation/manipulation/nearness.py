"""How near two solids are, fast: the grid says where to look, the surface decides."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray

from spatial_relations_ros.imitation.contact import Body

_MAX_EXACT = 128


def lowest_distance(body: Body, world_points: NDArray[np.floating]) -> float:
    """Smallest signed distance of world points (N, 3) to a body, metres; inf without points.

    Right where it is below the spacing of the body's grid; farther off it is the grid's estimate.
    """
    shape, local = body.shape, body.pose.inverse().apply(world_points).astype(np.float32)
    if not len(local):
        return float('inf')
    coarse = shape.field.sample(torch.from_numpy(local)).numpy()
    near = np.flatnonzero(coarse < shape.field.spacing)
    if shape.is_estimate or not len(near):
        return float(coarse.min())
    if len(near) > _MAX_EXACT:
        near = near[np.argpartition(coarse[near], _MAX_EXACT)[:_MAX_EXACT]]
    return float(shape.signed_distance(local[near]).min())


def signed_gap(first: Body, second: Body) -> float:
    """Metres between two bodies, negative by how deep they overlap; a few milliseconds.

    Measured at the surface points of both; an estimate where they are farther apart than the
    spacing of their grids.
    """
    if not _boxes_meet(first, second):
        return _box_gap(first, second)
    return min(
        lowest_distance(second, first.world_points), lowest_distance(first, second.world_points)
    )


def _box_gap(first: Body, second: Body) -> float:
    low, high = (
        np.array([b.world_points.min(axis=0), b.world_points.max(axis=0)]) for b in (first, second)
    )
    apart = np.maximum(np.maximum(low[0] - high[1], high[0] - low[1]), 0.0)
    return float(np.linalg.norm(apart))


def _boxes_meet(first: Body, second: Body) -> bool:
    return _box_gap(first, second) == 0.0
