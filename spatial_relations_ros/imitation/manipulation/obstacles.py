"""Other things in the scene, and how deep an object would reach into them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.spatial import KDTree

from spatial_relations_ros.core import CloudSource, InvalidSceneError, Pose, SceneObject
from spatial_relations_ros.imitation.contact import Body
from spatial_relations_ros.imitation.shape import Shape, shape_of

CELL = 0.004
STRAY_RADIUS = 0.03
_MIN_NEIGHBOURS = 3
_POSES_A_CHUNK = 64
_HASH = np.array([6364136223846793005, 2862933555777941757, 3202034522624059733])

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Obstacle:
    """Something that a placed object must not touch.

    Attributes:
        name: for people.
        points: (N, 3) of its surface in the world frame, metres, at most one a cell of 4 mm.
        item: the object, when its whole surface is known; then what is within it counts too.
    """

    name: str
    points: Points
    item: SceneObject | None = None

    @staticmethod
    def of_cloud(points: NDArray[np.floating], name: str = 'an obstacle') -> Obstacle:
        """An obstacle that is seen as a cloud, without the test objects in it.

        Args:
            points: (N, 3) in the world frame, metres; those that are not finite are left out.
            name: for people.

        Raises:
            InvalidSceneError: for another shape, or no finite point.
        """
        points = np.asarray(points, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise InvalidSceneError(f'{name}: expected points of shape (N, 3), got {points.shape}')
        finite = points[np.isfinite(points).all(axis=1)]
        if not len(finite):
            raise InvalidSceneError(f'{name}: none of its {len(points)} points is finite')
        return Obstacle(name, thinned(finite))

    @staticmethod
    def of_object(item: SceneObject) -> Obstacle:
        """An obstacle that is an object: solid when its model is known, else its live cloud."""
        cloud = Obstacle.of_cloud(item.world_from_object.apply(item.points), item.object_id)
        is_whole = item.mesh is not None or item.source == CloudSource.MODEL
        return Obstacle(item.object_id, cloud.points, item if is_whole else None)

    @cached_property
    def body(self) -> Body | None:
        """The solid; made when it is first needed."""
        if self.item is None:
            return None
        return Body(shape_of(self.item), self.item.world_from_object)

    @cached_property
    def box(self) -> Points:
        """Lowest and highest corner (2, 3) of the box around it, world frame."""
        return np.array([self.points.min(axis=0), self.points.max(axis=0)])

    @cached_property
    def tree(self) -> KDTree:
        """Its points, to look up neighbours."""
        return KDTree(self.points)

    def points_in(self, low: Points, high: Points) -> Points:
        """Its points (M, 3) within a box of the world."""
        if (self.box[1] < low).any() or (self.box[0] > high).any():
            return self.points[:0]
        return self.points[((self.points >= low) & (self.points <= high)).all(axis=1)]


def thinned(points: Points, cell: float = CELL) -> Points:
    """One point (M, 3) of each occupied cell of a grid."""
    cells = np.floor((points - points.min(axis=0)) / cell).astype(np.int64)
    # A hash (it may wrap around): sorting numbers is much faster than sorting triples.
    keys = cells @ _HASH
    return points[np.sort(np.unique(keys, return_index=True)[1])]


def without_strays(points: NDArray[np.floating], radius: float = STRAY_RADIUS) -> Points:
    """Points (M, 3) of a camera's cloud (N, 3) that have three others within a radius, metres.

    Between a near and a far surface a depth camera sees single points that are not there; one of
    them would forbid a placement.
    """
    cloud: Points = np.array(points, dtype=np.float64)
    if not len(cloud):
        return cloud
    counts = np.asarray(KDTree(cloud).query_ball_point(cloud, radius, return_length=True))
    return cloud[counts > _MIN_NEIGHBOURS]


def obstacle_depths(
    shape: Shape, poses: Sequence[Pose], obstacles: Sequence[Obstacle]
) -> NDArray[np.float64]:
    """How deep an object would reach into obstacles at many poses, fast and roughly.

    On the distance grid: right within a share of its spacing, and blind to walls thinner than
    that. :func:`check_obstacles` is exact.

    Args:
        shape: of the object.
        poses: K of world_from_object.
        obstacles: what it must not touch.

    Returns:
        (K,) metres, 0 where it is clear of all.
    """
    depths = np.zeros(len(poses))
    if not obstacles or not len(poses):
        return depths
    placed = _Placed(shape, poses)
    for obstacle in obstacles:
        near = placed.near(obstacle)
        if not len(near):
            continue
        depths[near] = np.maximum(depths[near], placed.cloud_depths(near, obstacle))
        if obstacle.body is not None:
            depths[near] = np.maximum(depths[near], placed.body_depths(near, obstacle.body))
    return depths


class _Placed:
    """One shape at many poses."""

    def __init__(self, shape: Shape, poses: Sequence[Pose]) -> None:
        self.shape = shape
        self.rotations = np.array([pose.rotation for pose in poses])
        self.translations = np.array([pose.translation for pose in poses])
        box = np.array([shape.points.min(axis=0), shape.points.max(axis=0)], dtype=np.float64)
        self.radius = 0.5 * float(np.linalg.norm(box[1] - box[0]))
        self.centres = self.rotations @ box.mean(axis=0) + self.translations

    def near(self, obstacle: Obstacle) -> NDArray[np.intp]:
        """Which poses (L,) come near the box of an obstacle."""
        low, high = obstacle.box
        apart = np.maximum(np.maximum(low - self.centres, self.centres - high), 0.0)
        return np.flatnonzero(np.einsum('ij,ij->i', apart, apart) <= self.radius**2)

    def cloud_depths(self, near: NDArray[np.intp], obstacle: Obstacle) -> NDArray[np.float64]:
        """How deep (L,) the obstacle's points are in the shape."""
        depths = np.zeros(len(near))
        for start in range(0, len(near), _POSES_A_CHUNK):
            part = near[start : start + _POSES_A_CHUNK]
            within = obstacle.tree.query_ball_point(self.centres[part], self.radius)
            counts = [len(points) for points in within]
            if not sum(counts):
                continue
            row = np.repeat(np.arange(len(part)), counts)
            point = np.concatenate(within).astype(np.int64)
            from_origin = obstacle.points[point] - self.translations[part[row]]
            local = np.einsum('nji,nj->ni', self.rotations[part[row]], from_origin)
            np.maximum.at(depths, start + row, -_sample(self.shape, local))
        return depths

    def body_depths(self, near: NDArray[np.intp], body: Body) -> NDArray[np.float64]:
        """How deep (L,) the shape's points are in a body."""
        surface = self.shape.points.astype(np.float64)
        depths = np.zeros(len(near))
        for start in range(0, len(near), _POSES_A_CHUNK):
            part = near[start : start + _POSES_A_CHUNK]
            world = surface @ self.rotations[part].transpose(0, 2, 1)
            world += self.translations[part][:, None]
            distances = _sample(body.shape, body.pose.inverse().apply(world))
            depths[start : start + len(part)] = np.maximum(-distances.min(axis=1), 0.0)
        return depths


def _sample(shape: Shape, points: Points) -> NDArray[np.float32]:
    local = torch.from_numpy(points.astype(np.float32))
    return np.asarray(shape.field.sample(local).numpy())
