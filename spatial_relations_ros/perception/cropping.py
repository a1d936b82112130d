"""Takes an object without a model out of the live cloud."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from spatial_relations_ros.core import ConfigError, Pose
from spatial_relations_ros.perception.camera import PinholeCamera
from spatial_relations_ros.perception.object_models import KnownModel
from spatial_relations_ros.perception.point_cloud2 import PointCloud
from spatial_relations_ros.perception.table import Plane

ALL_NEIGHBOURS = np.ones((3, 3, 3), dtype=int)
BOX_CORNERS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))


@dataclass(frozen=True)
class CropConfig:
    """How an object is cut out.

    Attributes:
        radius: how far from its pose an object reaches at most, metres.
        table_margin: points up to this height above the table belong to the table, metres.
        model_margin: points this near to the model of another object belong to that, metres.
        voxel: points in neighbouring voxels of this size belong together, metres.
        min_points: what is smaller is noise.
    """

    radius: float = 0.2
    table_margin: float = 0.008
    model_margin: float = 0.012
    voxel: float = 0.008
    min_points: int = 40

    def __post_init__(self) -> None:
        if not (0.01 <= self.radius <= 2.0 and 0.001 <= self.voxel <= self.radius):
            raise ConfigError(f'radius is 0.01 to 2 m, voxel 0.001 m to the radius, got {self}')
        if self.table_margin < 0 or self.model_margin < 0 or self.min_points < 4:
            raise ConfigError(f'margins must not be negative, min_points at least 4, got {self}')


def points_near(
    cloud: PointCloud, camera: PinholeCamera | None, centre: NDArray[np.float64], radius: float
) -> NDArray[np.float32]:
    """Finite points (N, 3) of a cloud in a ball, in the cloud's frame.

    Where the camera is known only the pixels that can see the ball are looked at.
    """
    if camera is not None and centre[2] > 1.5 * radius:
        corners = centre + radius * BOX_CORNERS
        columns, rows = camera.project(corners)
        window = (
            slice(max(int(rows.min()), 0), max(int(rows.max()) + 1, 0)),
            slice(max(int(columns.min()), 0), max(int(columns.max()) + 1, 0)),
        )
        points = cloud.window(*window).points
    else:
        points = cloud.points
    offsets = points - centre.astype(np.float32)
    near: NDArray[np.float32] = points[np.einsum('ij,ij->i', offsets, offsets) <= radius**2]
    return near


def without_models(
    world_points: NDArray[np.float64],
    others: Sequence[tuple[KnownModel, Pose]],
    margin: float,
) -> NDArray[np.float64]:
    """Points (N, 3) that are not on the surface of any model.

    Args:
        world_points: (N, 3) in the world.
        others: models with their ``world_from_object``.
        margin: how near to a model a point must be to belong to it, metres.
    """
    for model, world_from_object in others:
        object_points = world_from_object.inverse().apply(world_points)
        distances, _ = model.tree.query(object_points, distance_upper_bound=margin)
        world_points = world_points[np.isinf(distances)]
    return world_points


def crop_object(
    world_points: NDArray[np.float64],
    centre: NDArray[np.float64],
    table: Plane | None,
    others: Sequence[tuple[KnownModel, Pose]],
    rivals: Sequence[NDArray[np.float64]],
    config: CropConfig,
) -> NDArray[np.float64] | None:
    """The points of one object.

    Args:
        world_points: (N, 3) live points around the object, in the world.
        centre: (3,) where the tracker says the object is, in the world.
        table: the plane it stands on, where one is seen.
        others: known objects around it with their ``world_from_object``.
        rivals: (3,) where other objects without a model are. What touches cannot be told apart
            by its points: each takes those that are nearer to its own place.
        config: how it is cut out.

    Returns:
        The connected points (N, 3) nearest to ``centre`` that are neither table nor another
        object, or None when nothing of that size is there.
    """
    if table is not None:
        world_points = world_points[table.heights(world_points) > config.table_margin]
    world_points = without_models(world_points, others, config.model_margin)
    if len(world_points) < config.min_points:
        return None
    voxels = ((world_points - world_points.min(axis=0)) / config.voxel).astype(np.intp)
    grid = np.zeros(voxels.max(axis=0) + 1, dtype=bool)
    grid[tuple(voxels.T)] = True
    labelled, num_labels = ndimage.label(grid, structure=ALL_NEIGHBOURS)
    labels = labelled[tuple(voxels.T)]
    sizes = np.bincount(labels, minlength=num_labels + 1)
    is_large = sizes[labels] >= config.min_points
    world_points, labels = world_points[is_large], labels[is_large]
    if not len(world_points):
        return None
    distances = np.linalg.norm(world_points - centre, axis=1)
    rival_distances = [np.linalg.norm(world_points - rival, axis=1) for rival in rivals]
    kept = labels == _own_label(labels, distances, rival_distances)
    for others_distances in rival_distances:
        if kept[np.argmin(others_distances)]:
            kept &= distances <= others_distances
    cropped: NDArray[np.float64] = world_points[kept]
    return cropped if len(cropped) >= config.min_points else None


def _own_label(
    labels: NDArray[np.intp],
    distances: NDArray[np.floating],
    rival_distances: Sequence[NDArray[np.floating]],
) -> int:
    """The nearest cluster that is not on the whole nearer to another object; else the nearest."""
    candidates, first = np.unique(labels[np.argsort(distances, kind='stable')], return_index=True)
    candidates = candidates[np.argsort(first)]
    for label in candidates:
        members = labels == label
        mean = distances[members].mean()
        if all(mean <= other[members].mean() for other in rival_distances):
            return int(label)
    return int(candidates[0])
