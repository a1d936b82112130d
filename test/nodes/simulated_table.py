"""Two boxes on a table before a simulated Kinect2, as messages of a sensor and a tracker."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from manifold3d import Manifold
from sensor_msgs.msg import PointCloud2
from spatial_relations_msgs.msg import TrackedObject, TrackedObjectArray

from spatial_relations_ros.core import Pose, TriangleMesh
from spatial_relations_ros.datasets.kinect_simulator import (
    KinectSimulator,
    Surface,
    look_at,
    table_mesh,
)
from spatial_relations_ros.datasets.object_files import save_mesh
from spatial_relations_ros.perception.camera import PinholeCamera
from spatial_relations_ros.ros.conversions import cloud_to_msg, header_to_msg, pose_to_msg

SIZES = {'box': (0.16, 0.12, 0.10), 'post': (0.06, 0.06, 0.20)}
PLACES = {'box': (0.0, 0.2, 0.05), 'post': (0.1, -0.2, 0.10)}
CAMERA_POSE = look_at((-0.7, 0.0, 0.8), (0.05, 0.0, 0.0))
Place = Sequence[float]


def camera_of(width: int) -> PinholeCamera:
    """A camera with the Kinect2's view of about 70 by 60 degrees."""
    height = round(0.83 * width)
    return PinholeCamera(width, height, 0.714 * width, 0.714 * width, width / 2, height / 2)


class SimulatedTable:
    """Boxes and what a sensor measures of them.

    Args:
        folder: gets the models of the boxes.
        width: of the camera's image, pixels.
    """

    def __init__(self, folder: Path, width: int = 512) -> None:
        surfaces = [Surface(table_mesh((0.8, 1.0)))]
        for object_id, size in SIZES.items():
            solid = Manifold.cube(size, True).to_mesh()
            mesh = TriangleMesh(solid.vert_properties[:, :3], solid.tri_verts)
            save_mesh(folder / f'{object_id}.ply', mesh)
            surfaces.append(Surface(mesh.transformed(Pose(np.array(PLACES[object_id])))))
        self._surfaces = surfaces
        self._xyz = self.measured(width)

    @property
    def camera_pose(self) -> str:
        """As the parameter of that name takes it."""
        x, y, z = CAMERA_POSE.translation
        qw, qx, qy, qz = CAMERA_POSE.quat_wxyz
        return f'{x} {y} {z} {qx} {qy} {qz} {qw}'

    def measured(self, width: int) -> np.ndarray:
        """(H, W, 3) points of an image of some width, in the camera's frame."""
        simulator = KinectSimulator(self._surfaces, CAMERA_POSE, camera_of(width))
        return simulator.xyz(simulator.measure(np.random.default_rng(0)))

    def cloud(
        self, stamp_ns: int, frame_id: str = 'camera', xyz: np.ndarray | None = None
    ) -> PointCloud2:
        xyz = self._xyz if xyz is None else xyz
        cloud = cloud_to_msg(xyz.reshape(-1, 3), header_to_msg(stamp_ns, frame_id))
        cloud.height, cloud.width = xyz.shape[:2]
        cloud.row_step = cloud.width * cloud.point_step
        return cloud

    def tracks(
        self, stamp_ns: int, places: Mapping[str, Place] | None = None
    ) -> TrackedObjectArray:
        """Both boxes where they are, but for those that ``places`` moves, in metres."""
        message = TrackedObjectArray()
        for object_id, place in {**PLACES, **(places or {})}.items():
            message.objects.append(
                TrackedObject(
                    header=header_to_msg(stamp_ns, 'world'),
                    object_id=object_id,
                    pose=pose_to_msg(Pose(np.array(place))),
                    confidence=1.0,
                )
            )
        return message
