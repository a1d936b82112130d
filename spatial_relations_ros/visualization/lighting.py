"""A soft sun and a sky, as fixed sets of directions."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

SUN_ELEVATION_RAD = math.radians(54.0)
# The sun stands at the camera's left shoulder: shadows fall to the right and back.
SUN_BEHIND_CAMERA_RAD = math.radians(-48.0)
SUN_RADIUS = 0.085
SUN_STRENGTH = 0.62
SKY_STRENGTH = 0.50
# Share of the sky's light that comes back from the table on faces that look down.
BOUNCE = 0.55
GOLDEN_ANGLE_RAD = math.pi * (3.0 - math.sqrt(5.0))


@dataclass(frozen=True, eq=False)
class Sun:
    """A disk of light far away.

    Attributes:
        direction: (3,) unit, from the scene to the middle of the disk.
    """

    direction: FloatArray

    @staticmethod
    def beside_camera(camera_rotation: FloatArray) -> Sun:
        """The sun for a world-from-camera rotation (3, 3)."""
        back = -camera_rotation[:, 2]
        azimuth = math.atan2(back[1], back[0]) + SUN_BEHIND_CAMERA_RAD
        return Sun(
            np.array(
                [
                    math.cos(SUN_ELEVATION_RAD) * math.cos(azimuth),
                    math.cos(SUN_ELEVATION_RAD) * math.sin(azimuth),
                    math.sin(SUN_ELEVATION_RAD),
                ]
            )
        )

    def samples(self, num_directions: int) -> FloatArray:
        """Directions (num_directions, 3) spread over the disk."""
        side = np.cross(self.direction, [0.0, 0.0, 1.0])
        side /= np.linalg.norm(side)
        up = np.cross(side, self.direction)
        disk = spiral(num_directions) * SUN_RADIUS
        samples: FloatArray = self.direction + disk[:, :1] * side + disk[:, 1:] * up
        return samples


def spiral(num_points: int) -> FloatArray:
    """Points (num_points, 2) spread evenly over the unit disk (a sunflower)."""
    order = np.arange(num_points) + 0.5
    radius, angle = np.sqrt(order / num_points), order * GOLDEN_ANGLE_RAD
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def hemisphere(num_directions: int) -> FloatArray:
    """Unit directions (num_directions, 3) with z > 0, as dense as the cosine to z."""
    disk = spiral(num_directions)
    height = np.sqrt(np.maximum(1.0 - (disk**2).sum(axis=1), 0.0))
    return np.column_stack([disk, height])


def hemispheres(normals: NDArray[np.floating], num_directions: int) -> NDArray[np.float32]:
    """Directions (R, num_directions, 3): :func:`hemisphere` about each unit normal (R, 3).

    Each row's set is turned about its normal by another angle, so that the mean over neighbours
    shows no bands. The tangents follow Duff et al., "Building an Orthonormal Basis, Revisited",
    JCGT 2017.
    """
    x, y, z = np.asarray(normals, dtype=np.float32).T
    sign = np.where(z >= 0.0, np.float32(1.0), np.float32(-1.0))
    a = -1.0 / (sign + z)
    b = x * y * a
    along = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=1)
    across = np.stack([b, sign + y * y * a, -y], axis=1)
    turn = (np.arange(len(normals)) * GOLDEN_ANGLE_RAD).astype(np.float32)[:, None]
    cosine, sine = np.cos(turn), np.sin(turn)
    first, second = cosine * along + sine * across, cosine * across - sine * along
    frames = np.stack([first, second, np.stack([x, y, z], axis=1)], axis=1)
    directions: NDArray[np.float32] = hemisphere(num_directions).astype(np.float32) @ frames
    return directions
