"""A simulated Kinect2: clouds of a table top with the sensor's view, noise and blind spots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import open3d as o3d
from numpy.typing import NDArray
from scipy import ndimage

from spatial_relations_ros.core import ConfigError, Pose, TriangleMesh
from spatial_relations_ros.perception.camera import PinholeCamera

# The infrared camera's own intrinsics, as factory calibrations give them, and those of the
# colour camera at a quarter of its pixels.
SD_CAMERA = PinholeCamera(width=512, height=424, fx=365.5, fy=365.5, cx=254.9, cy=205.4)
QHD_CAMERA = PinholeCamera(width=960, height=540, fx=540.7, fy=540.7, cx=480.0, cy=270.0)


@dataclass(frozen=True)
class SensorModel:
    """How a Kinect2 fails.

    Attributes:
        min_range: nearer surfaces give no depth, metres.
        max_range: farther surfaces give no depth, metres.
        max_incidence_rad: surfaces seen at a larger angle to their normal give no depth; from
            ``fading_incidence_rad`` on fewer and fewer pixels do.
        fading_incidence_rad: see there.
        edge_step: a step in depth between neighbours by more than this is an edge, metres.
        flying_share: share of the pixels at edges that lie between both depths instead of being
            left out by the driver.
    """

    min_range: float = 0.5
    max_range: float = 4.5
    max_incidence_rad: float = float(np.deg2rad(85.0))
    fading_incidence_rad: float = float(np.deg2rad(72.0))
    edge_step: float = 0.025
    flying_share: float = 0.03

    def __post_init__(self) -> None:
        if not 0.0 < self.min_range < self.max_range:
            raise ConfigError(f'the range must be positive and not empty, got {self}')
        if not 0.0 < self.fading_incidence_rad < self.max_incidence_rad < np.pi / 2:
            raise ConfigError(f'angles must grow and stay below 90 degrees, got {self}')


@dataclass(frozen=True, eq=False)
class Surface:
    """Something that the sensor sees.

    Attributes:
        mesh: in the world.
        colour: red, green, blue, 0 to 255.
    """

    mesh: TriangleMesh
    colour: tuple[int, int, int] = (160, 160, 160)


@dataclass(frozen=True, eq=False)
class DepthImage:
    """What the sensor measures.

    Attributes:
        depth_mm: (H, W) uint16 along the optical axis; 0 where nothing came back.
        rgb: (H, W, 3) uint8.
    """

    depth_mm: NDArray[np.uint16]
    rgb: NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class _IdealView:
    """What a perfect sensor at the same place would see; infinite depth where nothing is."""

    depth: NDArray[np.float64]
    incidence_rad: NDArray[np.float64]
    rgb: NDArray[np.uint8]


class KinectSimulator:
    """A Kinect2 at a fixed pose before a scene that stands still.

    Args:
        surfaces: what it sees.
        world_from_camera: pose of the optical frame (x right, y down, z forward).
        camera: intrinsics and resolution.
        sensor: range, blind spots.
    """

    def __init__(
        self,
        surfaces: Sequence[Surface],
        world_from_camera: Pose,
        camera: PinholeCamera = SD_CAMERA,
        sensor: SensorModel | None = None,
    ) -> None:
        self.camera = camera
        self._sensor = sensor or SensorModel()
        self._view = _look(surfaces, world_from_camera, camera)

    def measure(self, rng: np.random.Generator) -> DepthImage:
        """One depth image, with noise drawn from ``rng``."""
        view, sensor = self._view, self._sensor
        near, far = _neighbourhood(view.depth)
        with np.errstate(invalid='ignore'):
            is_edge = (far - near > sensor.edge_step) & np.isfinite(view.depth)
        depth = np.where(is_edge, np.inf, view.depth)
        flying = is_edge & np.isfinite(far) & (rng.random(depth.shape) < sensor.flying_share)
        depth[flying] = rng.uniform(near[flying], far[flying])

        fading = (view.incidence_rad - sensor.fading_incidence_rad) / (
            sensor.max_incidence_rad - sensor.fading_incidence_rad
        )
        depth[rng.random(depth.shape) < fading] = np.inf
        depth[(depth < sensor.min_range) | (depth > sensor.max_range)] = np.inf

        measured = np.isfinite(depth)
        sigma = axial_noise_sigma(np.where(measured, depth, 0.0), view.incidence_rad)
        noisy = np.where(measured, depth, 0.0) + sigma * rng.standard_normal(depth.shape)
        depth_mm = np.where(measured, np.rint(1000.0 * noisy), 0.0).astype(np.uint16)
        return DepthImage(depth_mm, view.rgb)

    def xyz(self, image: DepthImage) -> NDArray[np.float32]:
        """(H, W, 3) points in the optical frame, metres; NaN where nothing came back."""
        depth = image.depth_mm.astype(np.float32) * np.float32(0.001)
        depth[image.depth_mm == 0] = np.nan
        points: NDArray[np.float32] = self.camera.rays() * depth[..., None]
        return points


def axial_noise_sigma(
    depth: NDArray[np.float64], incidence_rad: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Standard deviation of a Kinect2's depth, metres.

    The empirical model of Fankhauser et al., "Kinect v2 for mobile robot navigation: evaluation
    and modeling", ICAR 2015: in millimetres 1.5 - 0.5 z + 0.3 z^2 plus
    0.1 z^1.5 theta^2 / (pi/2 - theta)^2.

    Args:
        depth: distance along the optical axis, metres.
        incidence_rad: angle between the ray and the surface's normal, 0 to pi/2.
    """
    angle = np.minimum(incidence_rad, np.deg2rad(80.0))
    grazing = (angle / (np.pi / 2 - angle)) ** 2
    return 1e-3 * (1.5 - 0.5 * depth + 0.3 * depth**2 + 0.1 * depth**1.5 * grazing)


def look_at(position: tuple[float, float, float], target: tuple[float, float, float]) -> Pose:
    """``world_from_camera`` of an upright optical frame at a place that looks at another.

    Raises:
        ConfigError: when the camera would look straight up or down.
    """
    forward = np.subtract(target, position).astype(np.float64)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    if np.linalg.norm(right) < 1e-6:
        raise ConfigError(f'a camera at {position} has no upright view of {target}')
    forward /= np.linalg.norm(forward)
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    return Pose.from_rotation(np.stack([right, down, forward], axis=1), position)


def table_mesh(
    size: tuple[float, float], *, thickness: float = 0.03, height: float = 0.0
) -> TriangleMesh:
    """A table top centred at x = y = 0 with its upper face at ``height``, metres."""
    box = o3d.geometry.TriangleMesh.create_box(*size, thickness)
    box.translate((-size[0] / 2, -size[1] / 2, height - thickness))
    return TriangleMesh(np.asarray(box.vertices), np.asarray(box.triangles))


def _look(
    surfaces: Sequence[Surface], world_from_camera: Pose, camera: PinholeCamera
) -> _IdealView:
    scene = o3d.t.geometry.RaycastingScene()
    for surface in surfaces:
        scene.add_triangles(
            o3d.core.Tensor.from_numpy(surface.mesh.vertices),
            o3d.core.Tensor.from_numpy(surface.mesh.triangles.astype(np.uint32)),
        )
    directions = camera.rays().astype(np.float64) @ world_from_camera.rotation.T
    rays = np.empty((*directions.shape[:2], 6), dtype=np.float32)
    rays[..., :3] = world_from_camera.translation
    rays[..., 3:] = directions
    hits = scene.cast_rays(o3d.core.Tensor.from_numpy(rays))
    # The rays are scaled to z = 1: the length along one is the depth.
    depth = hits['t_hit'].numpy().astype(np.float64)
    normals = hits['primitive_normals'].numpy()
    lengths = np.linalg.norm(directions, axis=-1)
    cosine = np.abs(np.einsum('hwi,hwi->hw', normals, directions)) / lengths
    palette = np.array([surface.colour for surface in surfaces] + [(0, 0, 0)], dtype=np.float64)
    seen = hits['geometry_ids'].numpy()
    seen = np.where(np.isfinite(depth), seen, len(surfaces)).astype(np.intp)
    # Few shades: colours that change with every pixel would double the size of a recording.
    shade = 0.4 + 0.6 * np.rint(8.0 * cosine) / 8.0
    rgb = (palette[seen] * shade[..., None]).astype(np.uint8)
    return _IdealView(depth, np.arccos(np.clip(cosine, 0.0, 1.0)), rgb)


def _neighbourhood(
    depth: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Smallest and largest depth among each pixel and its eight neighbours."""
    near: NDArray[np.float64] = ndimage.minimum_filter(depth, size=3, mode='nearest')
    far: NDArray[np.float64] = ndimage.maximum_filter(depth, size=3, mode='nearest')
    return near, far
