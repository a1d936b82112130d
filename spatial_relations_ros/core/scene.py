"""Objects and scenes: what every other room passes around."""

from __future__ import annotations

import dataclasses
import enum
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core.errors import InvalidSceneError
from spatial_relations_ros.core.mesh import TriangleMesh
from spatial_relations_ros.core.pose import Pose

MIN_POINTS = 4


class CloudSource(enum.IntEnum):
    """Where an object's cloud comes from; values as in SceneObject.msg."""

    MODEL = 0
    OBSERVED = 1


@dataclass(frozen=True, eq=False)
class SceneObject:
    """An object with its cloud and its pose.

    Attributes:
        object_id: the tracker's name of the object.
        points: (N, 3) float32, object frame, metres, N >= 4.
        world_from_object: pose in a world whose z axis points up against gravity.
        source: MODEL when the cloud covers the whole surface, OBSERVED when it was seen live.
        support: share of the visible surface that the live cloud confirms, 0 to 1; NaN when it
            was not checked.
        mesh: the watertight surface in the object frame, where it is known.

    Raises:
        InvalidSceneError: for an empty id, too few points or points that are not finite.
    """

    object_id: str
    points: NDArray[np.float32]
    world_from_object: Pose
    source: CloudSource = CloudSource.MODEL
    support: float = math.nan
    mesh: TriangleMesh | None = None

    def __post_init__(self) -> None:
        if not self.object_id:
            raise InvalidSceneError('an object needs a non-empty id')
        points = np.ascontiguousarray(self.points, dtype=np.float32)
        if points.ndim != 2 or points.shape[1] != 3:
            raise InvalidSceneError(
                f'{self.object_id}: expected points of shape (N, 3), got {points.shape}'
            )
        if len(points) < MIN_POINTS:
            raise InvalidSceneError(
                f'{self.object_id}: the cloud has {len(points)} points, '
                f'at least {MIN_POINTS} are needed'
            )
        if not np.isfinite(points).all():
            bad = int((~np.isfinite(points).all(axis=1)).sum())
            raise InvalidSceneError(
                f'{self.object_id}: {bad} of {len(points)} points are not finite'
            )
        points.setflags(write=False)
        object.__setattr__(self, 'points', points)

    @property
    def world_points(self) -> NDArray[np.float32]:
        """The cloud in the world frame, (N, 3)."""
        return self.world_from_object.apply(self.points).astype(np.float32)

    def moved_to(self, world_from_object: Pose) -> SceneObject:
        """The same object at another pose."""
        return dataclasses.replace(self, world_from_object=world_from_object)


@dataclass(frozen=True, eq=False)
class Scene:
    """An ordered pair of objects: the relation of ``relative`` to ``base``.

    Attributes:
        base: the object that the relation refers to (the plate).
        relative: the object that stands in the relation (the cup).
        stamp_ns: time of the cloud, nanoseconds.
        frame_id: name of the world frame, z up.

    Raises:
        InvalidSceneError: when both objects have the same id.
    """

    base: SceneObject
    relative: SceneObject
    stamp_ns: int = 0
    frame_id: str = 'world'

    def __post_init__(self) -> None:
        if self.base.object_id == self.relative.object_id:
            raise InvalidSceneError(
                f'a scene needs two different objects, got {self.base.object_id!r} twice'
            )

    @property
    def objects(self) -> tuple[SceneObject, SceneObject]:
        """``(base, relative)``."""
        return self.base, self.relative

    @property
    def object_ids(self) -> tuple[str, str]:
        """Ids in the order base, relative."""
        return self.base.object_id, self.relative.object_id

    def with_poses(self, base: Pose, relative: Pose) -> Scene:
        """The same two objects at other poses."""
        return dataclasses.replace(
            self, base=self.base.moved_to(base), relative=self.relative.moved_to(relative)
        )
