"""Moves a tracked pose to where the live cloud shows the object's surface."""

from __future__ import annotations

import math
import weakref
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError, InvalidPoseError, Pose
from spatial_relations_ros.perception.camera import PinholeCamera
from spatial_relations_ros.perception.cropping import without_models
from spatial_relations_ros.perception.evidence import support_at
from spatial_relations_ros.perception.object_models import KnownModel
from spatial_relations_ros.perception.support import MIN_DEPTH, visible_points
from spatial_relations_ros.perception.view import View

NUM_MODEL_POINTS = 3000
NORMAL_NEIGHBOURS = 20
MIN_POINTS = 50
# The first pass catches the surface, the second settles on it.
PASSES = 2
MAX_ITERATIONS = 15
# Of metres and of the rotation matrix: a tenth of a micrometre.
DECIMALS = 7
# Live points this near to the table, or to the model of another object, are not the object's.
TABLE_MARGIN = 0.002
OTHERS_MARGIN = 0.006


@dataclass(frozen=True)
class RefineConfig:
    """How a pose is refined.

    Attributes:
        is_on: whether poses are refined at all.
        reach: how far from the model a live point may be, metres.
        num_points: how many live points are used at most.
        tolerance: depth difference of the support that must rise, metres. Finer than that of
            the belief, which one centimetre more or less does not change.
        max_turn_rad: a larger correction is not believed.
    """

    is_on: bool = False
    reach: float = 0.03
    num_points: int = 1500
    tolerance: float = 0.005
    max_turn_rad: float = 0.35

    def __post_init__(self) -> None:
        if not (0 < self.reach < 1 and 0 < self.tolerance < 1 and self.max_turn_rad > 0):
            raise ConfigError(f'reach and tolerance are 0 to 1 m, got {self}')
        if self.num_points < MIN_POINTS:
            raise ConfigError(f'num_points is {self.num_points}, at least {MIN_POINTS} are needed')


class PoseRefiner:
    """Point-to-plane ICP of the live points on the model's visible surface.

    Chen and Medioni, "Object modeling by registration of multiple range images", ICRA 1991; with
    Tukey's weights, so that what touches the object does not pull at it.
    """

    def __init__(self, config: RefineConfig | None = None) -> None:
        self.config = config or RefineConfig()
        # Models live as long as their source does; their normals no longer.
        self._surfaces: weakref.WeakKeyDictionary[KnownModel, _Surface] = (
            weakref.WeakKeyDictionary()
        )

    def refined(
        self,
        model: KnownModel,
        pose: Pose,
        view: View,
        others: Sequence[tuple[KnownModel, Pose]] = (),
    ) -> Pose:
        """The pose that the cloud supports more, or ``pose`` itself.

        Args:
            model: of the object.
            pose: ``world_from_object``, as tracked.
            view: the cloud.
            others: models around it with their ``world_from_object``; their points are not its.
        """
        camera = view.camera
        if camera is None:
            return pose
        surface = self._surfaces.get(model)
        if surface is None:
            surface = self._surfaces[model] = _Surface.of(model)
        seen = surface.seen_from(camera, view.to_cloud(pose.apply(surface.points)))
        live = self._live_points(view, camera, pose, surface.points[seen], others)
        if live is None:
            return pose
        try:
            object_from_live = self._registered(live, surface, seen)
        except InvalidPoseError:  # a surface that leaves the pose undetermined
            return pose
        turn_rad = 2.0 * math.acos(min(1.0, abs(float(object_from_live.quat_wxyz[0]))))
        shift = float(np.linalg.norm(object_from_live.apply(live).mean(0) - live.mean(0)))
        if turn_rad > self.config.max_turn_rad or shift > self.config.reach:
            return pose
        refined = pose @ object_from_live.inverse()
        is_better = self._support(model, refined, view) > self._support(model, pose, view)
        return refined if is_better else pose

    def _support(self, model: KnownModel, pose: Pose, view: View) -> float:
        """Fine support; 0 where the cloud cannot tell."""
        support = support_at(model.support_points, pose, view, self.config.tolerance)
        return 0.0 if math.isnan(support) else support

    def _live_points(
        self,
        view: View,
        camera: PinholeCamera,
        pose: Pose,
        surface: NDArray[np.float64],
        others: Sequence[tuple[KnownModel, Pose]],
    ) -> NDArray[np.float64] | None:
        """Live points (N, 3) in the box around the visible surface, object frame."""
        if len(surface) < MIN_POINTS:
            return None
        low, high = (
            surface.min(axis=0) - self.config.reach,
            surface.max(axis=0) + self.config.reach,
        )
        in_cloud = view.to_cloud(pose.apply(surface))
        columns, rows = camera.project(in_cloud)
        margin = math.ceil(self.config.reach * camera.fx / max(in_cloud[:, 2].min(), MIN_DEPTH))
        window = (
            slice(max(int(rows.min()) - margin, 0), max(int(rows.max()) + margin + 1, 0)),
            slice(max(int(columns.min()) - margin, 0), max(int(columns.max()) + margin + 1, 0)),
        )
        world_points = view.to_world(view.cloud.window(*window).points)
        if view.table is not None:
            world_points = world_points[view.table.heights(world_points) > TABLE_MARGIN]
        points = pose.inverse().apply(world_points)
        inside = ((points >= low) & (points <= high)).all(axis=1)
        world_points = world_points[inside]
        world_points = world_points[:: max(1, len(world_points) // self.config.num_points)]
        world_points = without_models(world_points, others, OTHERS_MARGIN)
        return None if len(world_points) < MIN_POINTS else pose.inverse().apply(world_points)

    def _registered(
        self, live: NDArray[np.float64], surface: _Surface, seen: NDArray[np.intp]
    ) -> Pose:
        registration = o3d.pipelines.registration
        source = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(live))
        target = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(surface.points[seen]))
        target.normals = o3d.utility.Vector3dVector(surface.normals[seen])
        matrix = np.eye(4)
        for pass_idx in range(PASSES):
            reach = self.config.reach / 3**pass_idx
            kernel = registration.TukeyLoss(k=reach)
            matrix = registration.registration_icp(
                source,
                target,
                reach,
                matrix,
                registration.TransformationEstimationPointToPlane(kernel),
                registration.ICPConvergenceCriteria(max_iteration=MAX_ITERATIONS),
            ).transformation
        # Open3D adds up in parallel, in any order: a replay must give the same bytes.
        return Pose.from_matrix(np.round(matrix, DECIMALS))


@dataclass(frozen=True, eq=False)
class _Surface:
    """Points (N, 3) and unit normals (N, 3) of a model, object frame."""

    points: NDArray[np.float64]
    normals: NDArray[np.float64]

    @staticmethod
    def of(model: KnownModel) -> _Surface:
        picks = np.linspace(0, len(model.points) - 1, min(NUM_MODEL_POINTS, len(model.points)))
        points = model.points[picks.round().astype(np.intp)]
        if model.mesh is None:
            cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points.astype(float)))
            cloud.estimate_normals(o3d.geometry.KDTreeSearchParamKNN(NORMAL_NEIGHBOURS))
            return _Surface(points.astype(float), np.array(cloud.normals))
        scene = o3d.t.geometry.RaycastingScene()
        scene.add_triangles(
            o3d.core.Tensor.from_numpy(model.mesh.vertices),
            o3d.core.Tensor.from_numpy(model.mesh.triangles.astype(np.uint32)),
        )
        nearest = scene.compute_closest_points(o3d.core.Tensor.from_numpy(points))
        normals = nearest['primitive_normals'].numpy().astype(float)
        return _Surface(points.astype(float), normals)

    def seen_from(
        self, camera: PinholeCamera, camera_points: NDArray[np.float64]
    ) -> NDArray[np.intp]:
        """Indices of the points that the camera sees, given all of them in its frame."""
        in_front = np.flatnonzero(camera_points[:, 2] > MIN_DEPTH)
        columns, rows = camera.project(camera_points[in_front])
        depths = camera_points[in_front, 2]
        return in_front[visible_points(columns, rows, depths, 0.005)]
