"""What a Kinect2 and a tracker send in the live benchmark: rendered clouds of four objects."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError, Pose
from spatial_relations_ros.datasets.kinect_simulator import (
    QHD_CAMERA,
    SD_CAMERA,
    KinectSimulator,
    Surface,
    table_mesh,
)
from spatial_relations_ros.datasets.object_files import save_mesh
from spatial_relations_ros.evaluation.demo_scenario import (
    IMITATIONS,
    make_scenario,
    scenario_surfaces,
    world_from_camera,
)
from spatial_relations_ros.perception.camera import PinholeCamera

CAMERA_FRAME = 'kinect2_optical_frame'
TRACKED_IDS = (*IMITATIONS[0].reference_ids, *IMITATIONS[0].test_ids)
PAIRS = (IMITATIONS[0].reference_ids, IMITATIONS[0].test_ids)
# Different draws of the sensor's noise, in turn.
NUM_CLOUDS = 8
FLOOR_SIZE = 8.0
FLOOR_COLOUR = (120, 120, 118)
HD_CAMERA = PinholeCamera(width=1920, height=1080, fx=1081.4, fy=1081.4, cx=959.5, cy=539.5)


@dataclass(frozen=True)
class StreamFormat:
    """The layout of a cloud.

    Attributes:
        name: as the command takes it.
        camera: of the cloud.
        point_step: bytes of a point; x, y, z at 0, 4, 8, and rgb in the last four of 16 or at 16
            of 32, as depth_image_proc and PCL lay them out.
    """

    name: str
    camera: PinholeCamera
    point_step: int

    @property
    def num_bytes(self) -> int:
        """Of one cloud."""
        return self.camera.width * self.camera.height * self.point_step


FORMATS = {
    item.name: item
    for item in (
        StreamFormat('sd', SD_CAMERA, 16),
        StreamFormat('sd32', SD_CAMERA, 32),
        StreamFormat('qhd', QHD_CAMERA, 16),
        StreamFormat('hd', HD_CAMERA, 16),
    )
}


def stream_format(name: str) -> StreamFormat:
    """The layout of that name.

    Raises:
        ConfigError: when there is none.
    """
    if name not in FORMATS:
        raise ConfigError(f'no stream {name!r}; expected one of {", ".join(FORMATS)}')
    return FORMATS[name]


@dataclass(frozen=True, eq=False)
class RenderedStream:
    """A table that stands still, as the sensor sees it.

    Attributes:
        layout: of the clouds.
        clouds: (K, H, W * point_step) uint8, the data of K messages.
        poses: camera_from_object by id.
        world_from_camera: the sensor's pose.
    """

    layout: StreamFormat
    clouds: NDArray[np.uint8]
    poses: dict[str, Pose]
    world_from_camera: Pose


def render_stream(layout: StreamFormat, models_folder: Path, *, seed: int = 5) -> RenderedStream:
    """Renders the demonstration's table on a floor.

    Args:
        layout: of the clouds.
        models_folder: gets the meshes of the tracked objects, named by id.
        seed: of table and noise.
    """
    objects = make_scenario(seed)
    # In a room most pixels measure something.
    floor = Surface(table_mesh((FLOOR_SIZE, FLOOR_SIZE)), FLOOR_COLOUR)
    surfaces = [*scenario_surfaces(objects), floor]
    simulator = KinectSimulator(surfaces, world_from_camera(), layout.camera)
    rng = np.random.default_rng(seed)
    clouds = []
    for _ in range(NUM_CLOUDS):
        image = simulator.measure(rng)
        clouds.append(_packed(simulator.xyz(image), image.rgb, layout.point_step))
    camera_from_world = world_from_camera().inverse()
    poses = {}
    for item in objects:
        if item.object_id in TRACKED_IDS:
            save_mesh(models_folder / f'{item.object_id}.ply', item.model.mesh)
            poses[item.object_id] = camera_from_world @ item.world_from_object
    return RenderedStream(layout, np.stack(clouds), poses, world_from_camera())


def _packed(
    xyz: NDArray[np.float32], rgb: NDArray[np.uint8], point_step: int
) -> NDArray[np.uint8]:
    """(H, W * point_step) bytes of one message."""
    height, width = xyz.shape[:2]
    points = np.zeros((height, width, point_step), dtype=np.uint8)
    points[..., :12] = xyz.astype('<f4').view(np.uint8)
    offset = rgb_offset(point_step)
    points[..., offset : offset + 3] = rgb[..., ::-1]
    return points.reshape(height, -1)


def rgb_offset(point_step: int) -> int:
    """Where the colour of a point is."""
    return 12 if point_step == 16 else 16
