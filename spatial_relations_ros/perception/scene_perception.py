"""From a cloud and tracked poses to objects in the world: the one step of live and replay."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import (
    CloudFormatError,
    CloudSource,
    FrameTransformError,
    InvalidPoseError,
    InvalidSceneError,
    Pose,
    SceneObject,
)
from spatial_relations_ros.perception.border import Frame, FrameResult, StampedTransform
from spatial_relations_ros.perception.camera import PinholeCamera, estimate_camera
from spatial_relations_ros.perception.config import PerceptionConfig
from spatial_relations_ros.perception.cropping import crop_object, points_near, without_models
from spatial_relations_ros.perception.frames import TransformBuffer
from spatial_relations_ros.perception.object_models import KnownModel, ModelSource, NoModels
from spatial_relations_ros.perception.point_cloud2 import PointCloud
from spatial_relations_ros.perception.series import NS_PER_SEC
from spatial_relations_ros.perception.support import count_support
from spatial_relations_ros.perception.table import Plane, find_table
from spatial_relations_ros.perception.tracks import TrackBuffer, TrackRejectedError


@dataclass(frozen=True, eq=False)
class _View:
    """One cloud, its camera, where it is in the world, and the table in it."""

    cloud: PointCloud
    camera: PinholeCamera | None
    world_from_cloud: NDArray[np.float64]
    table: Plane | None

    def to_world(self, points: NDArray[np.floating]) -> NDArray[np.float64]:
        """Points (..., 3) of the cloud's frame in the world."""
        matrix = self.world_from_cloud
        world_points: NDArray[np.float64] = points @ matrix[:3, :3].T + matrix[:3, 3]
        return world_points

    def to_cloud(self, points: NDArray[np.floating]) -> NDArray[np.float64]:
        """Points (..., 3) of the world in the cloud's frame."""
        matrix = self.world_from_cloud
        cloud_points: NDArray[np.float64] = (points - matrix[:3, 3]) @ matrix[:3, :3]
        return cloud_points


class ScenePerception:
    """Remembers transforms and tracked poses; makes objects of each cloud.

    The results depend on nothing but the frames that were given, in their order: a replayed bag
    gives the same results each time.

    Args:
        config: how clouds and poses become objects.
        models: where the objects' models come from; without it all objects are observed.
    """

    def __init__(
        self, config: PerceptionConfig | None = None, models: ModelSource | None = None
    ) -> None:
        self.config = config or PerceptionConfig()
        self.transforms = TransformBuffer(self.config.transforms)
        self._models = models or NoModels()
        self._tracks = TrackBuffer(self.config.tracks)
        self._last_stamp_ns: int | None = None

    def add_transform(self, transform: StampedTransform) -> None:
        """Stores a transform outside of a frame, such as a camera pose given as a parameter.

        Raises:
            FrameTransformError: when it cannot be part of a tree of frames.
        """
        self.transforms.add(transform)

    def reset(self) -> None:
        """Forgets tracked poses and moving transforms, as after a jump of the clock."""
        self._tracks.clear()
        self.transforms.forget_moving()
        self._last_stamp_ns = None

    def step(self, frame: Frame) -> FrameResult:
        """Makes objects of one frame.

        Nothing that a sensor or tracker sends makes this raise: what cannot be used is in the
        result with its reason.
        """
        faults = self._remember(frame)
        num_points = frame.cloud.num_finite
        if num_points == 0:
            return self._unusable(
                frame, f'no finite points in the cloud of {frame.cloud.num_total}'
            )
        try:
            world_from_cloud = self.transforms.lookup(
                self.config.world_frame, frame.frame_id, frame.stamp_ns
            )
        except FrameTransformError as error:
            return self._unusable(frame, f'the cloud cannot be used: {error}')
        poses, rejected = self._poses(frame.stamp_ns)
        thin_points = self._thin_world_points(frame.cloud, world_from_cloud)
        table = self._find_table(thin_points, poses)
        camera = estimate_camera(frame.cloud)
        view = _View(frame.cloud, camera, world_from_cloud.as_matrix(), table)
        known = self._known(poses, rejected)
        objects: dict[str, SceneObject] = {}
        for object_id in poses:
            try:
                objects[object_id] = (
                    self._from_model(object_id, *known[object_id], view)
                    if object_id in known
                    else self._from_cloud(object_id, poses, known, view)
                )
            except (TrackRejectedError, InvalidSceneError) as error:
                rejected[object_id] = str(error)
        unread = {object_id: faults[object_id] for object_id in faults if object_id not in objects}
        return FrameResult(
            stamp_ns=frame.stamp_ns,
            frame_id=self.config.world_frame,
            objects=objects,
            rejected=unread | rejected,
            num_points=num_points,
            table_height=_table_height(table, poses, thin_points),
            obstacles=self._obstacles(thin_points, table, objects, known),
        )

    def _remember(self, frame: Frame) -> dict[str, str]:
        """Takes up what came with the frame; gives the reasons for what could not be used."""
        jump_ns = self.config.tracks.jump_back_sec * NS_PER_SEC
        if self._last_stamp_ns is not None and frame.stamp_ns < self._last_stamp_ns - jump_ns:
            self.reset()
        self._last_stamp_ns = frame.stamp_ns
        faults = {fault.object_id: fault.reason for fault in frame.faults}
        for transform in frame.transforms:
            try:
                self.transforms.add(transform)
            except FrameTransformError as error:
                faults[transform.child_frame] = str(error)
        for track in frame.tracks:
            self._tracks.add(track)
        return faults

    def _unusable(self, frame: Frame, problem: str) -> FrameResult:
        object_ids = (*self._tracks.object_ids, *self.config.object_frames)
        return FrameResult(
            stamp_ns=frame.stamp_ns,
            frame_id=self.config.world_frame,
            rejected=dict.fromkeys(object_ids, problem),
            problem=problem,
            num_points=frame.cloud.num_finite,
        )

    def _poses(self, stamp_ns: int) -> tuple[dict[str, Pose], dict[str, str]]:
        """``world_from_object`` of each object that is believed, and why others are not."""
        poses: dict[str, Pose] = {}
        rejected: dict[str, str] = {}
        world = self.config.world_frame
        for object_id in sorted({*self._tracks.object_ids, *self.config.object_frames}):
            try:
                if object_id in self._tracks.object_ids:
                    poses[object_id] = self._tracks.world_from_object(
                        object_id, stamp_ns, self.transforms, world
                    )
                else:
                    poses[object_id] = self.transforms.lookup(world, object_id, stamp_ns)
            except (TrackRejectedError, FrameTransformError, InvalidPoseError) as error:
                rejected[object_id] = str(error)
        return poses, rejected

    def _known(
        self, poses: dict[str, Pose], rejected: dict[str, str]
    ) -> dict[str, tuple[KnownModel, Pose]]:
        """The models of those objects that have one; an object with a bad model is refused."""
        known = {}
        for object_id in tuple(poses):
            try:
                model = self._models.find(object_id)
            except CloudFormatError as error:
                rejected[object_id] = f'its model cannot be used: {error}'
                del poses[object_id]
                continue
            if model is not None:
                known[object_id] = model, poses[object_id]
        return known

    def _thin_world_points(self, cloud: PointCloud, world_from_cloud: Pose) -> NDArray[np.float64]:
        points = cloud.decimated(self.config.thin_stride).points
        in_range = np.einsum('ij,ij->i', points, points) <= self.config.max_range**2
        return world_from_cloud.apply(points[in_range])

    def _find_table(
        self, world_points: NDArray[np.float64], poses: Mapping[str, Pose]
    ) -> Plane | None:
        """The table around and below the objects; the floor beside it is larger in many views."""
        if poses:
            centres = np.array([pose.translation for pose in poses.values()])
            reach = self.config.table_reach
            low, high = centres.min(axis=0) - reach, centres.max(axis=0) + reach
            high[2] = centres[:, 2].max()
            world_points = world_points[((world_points >= low) & (world_points <= high)).all(1)]
        return find_table(world_points, np.random.default_rng(self.config.seed))

    def _from_model(
        self, object_id: str, model: KnownModel, pose: Pose, view: _View
    ) -> SceneObject:
        support = math.nan
        if view.camera is not None:
            count = count_support(
                view.to_cloud(pose.apply(model.support_points)),
                view.cloud,
                view.camera,
                tolerance=self.config.support_tolerance,
            )
            support = count.support
        if support < self.config.min_support:
            raise TrackRejectedError(
                f'the tracked pose has no support in the cloud ({100 * support:.0f} %, '
                f'at least {100 * self.config.min_support:.0f} % is needed)'
            )
        return SceneObject(object_id, model.points, pose, CloudSource.MODEL, support, model.mesh)

    def _from_cloud(
        self,
        object_id: str,
        poses: Mapping[str, Pose],
        known: Mapping[str, tuple[KnownModel, Pose]],
        view: _View,
    ) -> SceneObject:
        crop, pose = self.config.crop, poses[object_id]
        centre = view.to_cloud(pose.translation)
        rivals = [
            other.translation
            for other_id, other in poses.items()
            if other_id not in known and other_id != object_id and _are_near(pose, other)
        ]
        points = crop_object(
            view.to_world(points_near(view.cloud, view.camera, centre, crop.radius)),
            pose.translation,
            view.table,
            [(model, other) for model, other in known.values() if _are_near(pose, other)],
            rivals,
            crop,
        )
        if points is None:
            raise TrackRejectedError(
                f'there is no model, and nothing of its own is seen within {crop.radius:.2f} m '
                'of the tracked pose'
            )
        object_points = pose.inverse().apply(points).astype(np.float32)
        return SceneObject(object_id, object_points, pose, CloudSource.OBSERVED)

    def _obstacles(
        self,
        thin_points: NDArray[np.float64],
        table: Plane | None,
        objects: Mapping[str, SceneObject],
        known: Mapping[str, tuple[KnownModel, Pose]],
    ) -> NDArray[np.float32] | None:
        if not self.config.find_obstacles:
            return None
        crop = self.config.crop
        points = thin_points
        if table is not None:
            points = points[table.heights(points) > crop.table_margin]
        points = without_models(points, [known[i] for i in objects if i in known], 0.02)
        for item in objects.values():
            if item.source == CloudSource.OBSERVED:
                seen = KnownModel(item.points)
                points = without_models(points, [(seen, item.world_from_object)], 0.02)
        return points.astype(np.float32)


def _are_near(first: Pose, second: Pose) -> bool:
    return bool(np.linalg.norm(first.translation - second.translation) < 1.0)


def _table_height(
    table: Plane | None, poses: Mapping[str, Pose], thin_points: NDArray[np.float64]
) -> float | None:
    """World z of the table in the middle of the objects."""
    if table is None:
        return None
    places = np.array([pose.translation for pose in poses.values()]) if poses else thin_points
    x, y, _ = places.mean(axis=0)
    return table.z_at(float(x), float(y))
