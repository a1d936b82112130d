"""A pinhole camera, and the one that frames a scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError, Pose, SceneObject

FloatArray = NDArray[np.float64]

FIELD_OF_VIEW_RAD = math.radians(26.0)
ELEVATION_RAD = math.radians(27.0)
PREFERRED_AZIMUTH_RAD = math.radians(-62.0)
# Looks into containers.
STEEP_ELEVATION_RAD = math.radians(48.0)
TURNS_DEG = (0.0, 35.0, -35.0, 70.0, -70.0)
VIEW_PENALTY = 0.03
HIDDEN_POINTS = 2000
MARGIN = 0.86
MIN_EXTENT = 1e-3


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera with square pixels and its principal point in the middle.

    Attributes:
        world_from_camera: optical frame: x right, y down, z forward (REP-103).
        focal_length: in pixels.
        width: pixels.
        height: pixels.

    Raises:
        ConfigError: for a picture without pixels or a focal length that is not positive.
    """

    world_from_camera: Pose
    focal_length: float
    width: int = 800
    height: int = 600

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1 or not self.focal_length > 0.0:
            raise ConfigError(
                f'a camera needs pixels and a positive focal length, got {self.width} x '
                f'{self.height} and {self.focal_length}'
            )

    @property
    def position(self) -> FloatArray:
        """The optical centre in the world, (3,) metres."""
        return self.world_from_camera.translation

    def project(self, points: NDArray[np.floating]) -> tuple[FloatArray, FloatArray]:
        """Pixels and depths of world points (..., 3).

        Returns:
            ``(pixels, depth)``: pixels (..., 2) as column, row with (0, 0) the centre of the
            first pixel; depth (...) in metres along the optical axis. Pixels of points that are
            not in front of the camera mean nothing.
        """
        local = self.world_from_camera.inverse().apply(points)
        depth = local[..., 2]
        safe = np.where(np.abs(depth) < 1e-12, 1e-12, depth)
        pixels = local[..., :2] / safe[..., None] * self.focal_length
        return pixels + np.array([(self.width - 1) / 2.0, (self.height - 1) / 2.0]), depth

    def ray_directions(self, pixels: NDArray[np.floating]) -> NDArray[np.float32]:
        """World directions (..., 3) through pixels (..., 2); one metre of depth long."""
        centre = np.array([(self.width - 1) / 2.0, (self.height - 1) / 2.0])
        local = np.ones((*pixels.shape[:-1], 3), dtype=np.float32)
        local[..., :2] = (pixels - centre) / self.focal_length
        directions: NDArray[np.float32] = local @ self.world_from_camera.rotation.T.astype(
            np.float32
        )
        return directions


def optical_rotation(azimuth_rad: float, elevation_rad: float) -> FloatArray:
    """World-from-camera rotation of a camera that stands at these angles and looks back.

    Args:
        azimuth_rad: of the camera seen from the scene, about z from the x axis.
        elevation_rad: of the camera over the table.
    """
    forward = -np.array(
        [
            math.cos(elevation_rad) * math.cos(azimuth_rad),
            math.cos(elevation_rad) * math.sin(azimuth_rad),
            math.sin(elevation_rad),
        ]
    )
    right = np.array([-math.sin(azimuth_rad), math.cos(azimuth_rad), 0.0])
    return np.stack([right, np.cross(forward, right), forward], axis=1)


def frame_points(
    points: NDArray[np.floating],
    *,
    azimuth_rad: float = PREFERRED_AZIMUTH_RAD,
    elevation_rad: float = ELEVATION_RAD,
    width: int = 800,
    height: int = 600,
) -> Camera:
    """The camera from that direction that shows all points as large as they fit.

    The picture's four sides are planes through the optical centre; the nearest centre for which
    all points lie inside all four follows from the extreme points of each plane.

    Args:
        points: (N, 3) world, metres.
        azimuth_rad: of the camera seen from the scene.
        elevation_rad: of the camera over the table.
        width: pixels.
        height: pixels.
    """
    rotation = optical_rotation(azimuth_rad, elevation_rad)
    local = np.asarray(points, dtype=np.float64) @ rotation
    focal_length = height / (2.0 * math.tan(FIELD_OF_VIEW_RAD / 2.0))
    centre = np.zeros(3)
    limits = []
    for axis, size in ((0, width), (1, height)):
        slope = MARGIN * size / (2.0 * focal_length)
        upper = float((local[:, axis] - slope * local[:, 2]).max())
        lower = float((local[:, axis] + slope * local[:, 2]).min())
        centre[axis] = (upper + lower) / 2.0
        limits.append((lower - upper) / (2.0 * slope))
    nearest = float(local[:, 2].min())
    extent = max(float(np.ptp(local, axis=0).max()), MIN_EXTENT)
    centre[2] = min(*limits, nearest - extent)
    return Camera(
        Pose.from_rotation(rotation, rotation @ centre), focal_length, width=width, height=height
    )


def frame_objects(
    groups: Sequence[Sequence[SceneObject]], *, width: int = 800, height: int = 600
) -> Camera:
    """One camera for several states of a scene, from a side where no object hides another.

    Args:
        groups: the objects of each state (before, after).
        width: pixels.
        height: pixels.

    Raises:
        ConfigError: without any object.
    """
    objects = [scene_object for group in groups for scene_object in group]
    if not objects:
        raise ConfigError('no objects to frame')
    views = [
        (azimuth, elevation)
        for elevation in (ELEVATION_RAD, STEEP_ELEVATION_RAD)
        for azimuth in (PREFERRED_AZIMUTH_RAD + math.radians(turn) for turn in TURNS_DEG)
    ]
    hidden = [
        max(hidden_share(group, azimuth, elevation) for group in groups if group)
        for azimuth, elevation in views
    ]
    # The preferred view unless another one shows clearly more.
    penalty = [VIEW_PENALTY * order for order in range(len(views))]
    azimuth, elevation = views[int(np.argmin(np.add(hidden, penalty)))]
    points = np.concatenate([outline_points(scene_object) for scene_object in objects])
    return frame_points(
        points, azimuth_rad=azimuth, elevation_rad=elevation, width=width, height=height
    )


def outline_points(scene_object: SceneObject) -> FloatArray:
    """World points (N, 3) whose hull holds the object as it is drawn."""
    if scene_object.mesh is not None:
        return scene_object.world_from_object.apply(scene_object.mesh.vertices)
    return scene_object.world_from_object.apply(scene_object.points)


def hidden_share(
    objects: Sequence[SceneObject], azimuth_rad: float, elevation_rad: float
) -> float:
    """The largest share, 0 to 1, of an object that the others hide from that direction.

    Clouds are dropped into a coarse grid across the line of sight (orthographic); a cell shows
    the object that is nearest in it.
    """
    if len(objects) < 2:
        return 0.0
    rotation = optical_rotation(azimuth_rad, elevation_rad)
    locals_ = [
        scene_object.world_points[:: max(1, len(scene_object.points) // HIDDEN_POINTS)] @ rotation
        for scene_object in objects
    ]
    stacked = np.concatenate(locals_)
    low = stacked.min(axis=0)
    cell = max(float(np.ptp(stacked[:, :2], axis=0).max()), MIN_EXTENT) / 32.0
    depth = np.full((len(objects), 34, 34), np.inf)
    for object_idx, local in enumerate(locals_):
        cells = ((local[:, :2] - low[:2]) / cell).astype(np.int64)
        np.minimum.at(depth[object_idx], (cells[:, 0], cells[:, 1]), local[:, 2])
    nearest = depth.min(axis=0)
    covered = np.isfinite(depth)
    hidden = covered & (depth > nearest[None])
    return float((hidden.sum(axis=(1, 2)) / covered.sum(axis=(1, 2))).max())
