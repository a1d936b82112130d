"""One cloud with its camera, its place in the world and the table in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.perception.camera import PinholeCamera
from spatial_relations_ros.perception.point_cloud2 import PointCloud
from spatial_relations_ros.perception.table import Plane


@dataclass(frozen=True, eq=False)
class View:
    """What perception knows at one cloud's time besides the objects.

    Attributes:
        cloud: the live cloud, in the sensor's frame.
        camera: that made it; None for clouds that are not a pinhole camera's.
        world_from_cloud: (4, 4).
        table: the plane that the objects stand on, in the world; None if none is seen.
    """

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
