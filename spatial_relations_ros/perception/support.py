"""How much of an object the live cloud confirms where its tracker says it is."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.perception.camera import PinholeCamera
from spatial_relations_ros.perception.point_cloud2 import PointCloud

MIN_DEPTH = 0.05
MIN_COUNTED_POINTS = 20
MIN_COUNTED_SHARE = 0.05
POINTS_PER_CELL = 4


@dataclass(frozen=True)
class SupportCount:
    """What the camera says about the points of a model that should be visible.

    Attributes:
        num_confirmed: the measured depth is that of the model.
        num_contradicted: the camera looks through the place where the model should be.
        num_occluded: something else is in front.
        num_unmeasured: nothing came back from there, or it is outside of the image.
    """

    num_confirmed: int
    num_contradicted: int
    num_occluded: int
    num_unmeasured: int

    @property
    def support(self) -> float:
        """Share of the points that count, 0 to 1, that is confirmed.

        NaN when too few points count: occlusion and missing returns are evidence of nothing.
        """
        num_counted = self.num_confirmed + self.num_contradicted
        num_visible = num_counted + self.num_occluded + self.num_unmeasured
        if num_counted < max(MIN_COUNTED_POINTS, MIN_COUNTED_SHARE * num_visible):
            return math.nan
        return self.num_confirmed / num_counted


def count_support(
    points: NDArray[np.floating],
    cloud: PointCloud,
    camera: PinholeCamera,
    *,
    tolerance: float,
    is_sunk: NDArray[np.bool_] | None = None,
) -> SupportCount:
    """Compares a model with the measured depth, pixel by pixel.

    Args:
        points: (N, 3) spread over the model's surface, in the cloud's optical frame.
        cloud: the organised live cloud.
        camera: the camera that made it.
        tolerance: depth difference that is still the same surface, metres.
        is_sunk: (N,) points that would be inside of the table. What hides them speaks against
            the pose, since no object is there.
    """
    points = np.asarray(points, dtype=np.float64)
    in_front = points[:, 2] > MIN_DEPTH
    points = points[in_front]
    sunk = np.zeros(len(points), dtype=bool) if is_sunk is None else is_sunk[in_front]
    columns, rows = camera.project(points)
    visible = visible_points(columns, rows, points[:, 2], tolerance)
    columns, rows, depths = columns[visible], rows[visible], points[visible, 2]
    inside = (columns >= 1) & (columns < camera.width - 1)
    inside &= (rows >= 1) & (rows < camera.height - 1)
    num_outside = int(np.count_nonzero(~inside))
    columns, rows, depths = columns[inside], rows[inside], depths[inside]
    sunk = sunk[visible][inside]
    depth_image = cloud.xyz[..., 2]
    confirmed = np.abs(depth_image[rows, columns] - depths) <= tolerance
    num_confirmed = int(np.count_nonzero(confirmed))
    # Where its own pixel does not confirm a point, a neighbour may: the pose jitters by about a
    # pixel, and the sensor leaves out pixels at edges.
    rows, columns, depths = rows[~confirmed], columns[~confirmed], depths[~confirmed]
    sunk = sunk[~confirmed]
    shift = np.array([-1, 0, 1])
    row_idx = rows[:, None, None] + shift[:, None]
    column_idx = columns[:, None, None] + shift
    measured = depth_image[row_idx, column_idx].reshape(len(rows), 9)
    behind = np.where(np.isfinite(measured), measured, np.nan) - depths[:, None]
    confirmed = (np.abs(behind) <= tolerance).any(axis=1)
    occluded = ~confirmed & (behind < -tolerance).any(axis=1)
    contradicted = ~confirmed & ~occluded & (behind > tolerance).any(axis=1)
    contradicted |= occluded & sunk
    occluded &= ~sunk
    num_unmeasured = int(np.count_nonzero(~(confirmed | occluded | contradicted)))
    return SupportCount(
        num_confirmed=num_confirmed + int(np.count_nonzero(confirmed)),
        num_contradicted=int(np.count_nonzero(contradicted)),
        num_occluded=int(np.count_nonzero(occluded)),
        num_unmeasured=num_unmeasured + num_outside,
    )


def looked_through(
    points: NDArray[np.floating], cloud: PointCloud, camera: PinholeCamera, *, tolerance: float
) -> NDArray[np.bool_]:
    """Which points (N,) cannot be there, since the camera sees something behind them.

    Args:
        points: (N, 3) in the cloud's optical frame.
        cloud: the organised live cloud.
        camera: the camera that made it.
        tolerance: how far behind a point that must be, metres.
    """
    points = np.asarray(points, dtype=np.float64)
    through = np.zeros(len(points), dtype=bool)
    candidates = np.flatnonzero(points[:, 2] > MIN_DEPTH)
    columns, rows = camera.project(points[candidates])
    inside = (columns >= 0) & (columns < camera.width) & (rows >= 0) & (rows < camera.height)
    candidates, columns, rows = candidates[inside], columns[inside], rows[inside]
    measured = cloud.xyz[rows, columns, 2]
    with np.errstate(invalid='ignore'):
        behind = np.isfinite(measured) & (measured - points[candidates, 2] > tolerance)
    through[candidates[behind]] = True
    return through


def visible_points(
    columns: NDArray[np.intp],
    rows: NDArray[np.intp],
    depths: NDArray[np.floating],
    tolerance: float,
) -> NDArray[np.bool_]:
    """Which points a z-buffer leaves over that is coarse enough to have no holes.

    Args:
        columns: (N,) of the points' pixels.
        rows: (N,) of the points' pixels.
        depths: (N,) of the points, metres.
        tolerance: how far behind the nearest one a point still belongs to the same surface.
    """
    if not len(depths):
        return np.zeros(0, dtype=bool)
    left, top = int(columns.min()), int(rows.min())
    area = (int(columns.max()) - left + 1) * (int(rows.max()) - top + 1)
    cell = max(1, math.ceil(math.sqrt(POINTS_PER_CELL * area / len(depths))))
    cell_columns, cell_rows = (columns - left) // cell, (rows - top) // cell
    cell_idx = cell_rows * (cell_columns.max() + 1) + cell_columns
    nearest = np.full(int(cell_idx.max()) + 1, np.inf)
    np.minimum.at(nearest, cell_idx, depths)
    visible: NDArray[np.bool_] = depths <= nearest[cell_idx] + tolerance
    return visible
