"""Quaternion orders and rotation matrices.

The core writes quaternions scalar first (``quat_wxyz``); ROS messages and roma write them scalar
last (``quat_xyzw``). These two functions are the only places where the order changes.
"""

from __future__ import annotations

import numpy as np
import roma
import torch
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def xyzw_from_wxyz(quat_wxyz: FloatArray) -> FloatArray:
    """Moves the scalar part of quaternions (..., 4) from first to last."""
    return np.roll(np.asarray(quat_wxyz, dtype=np.float64), -1, axis=-1)


def wxyz_from_xyzw(quat_xyzw: FloatArray) -> FloatArray:
    """Moves the scalar part of quaternions (..., 4) from last to first."""
    return np.roll(np.asarray(quat_xyzw, dtype=np.float64), 1, axis=-1)


def matrix_from_quat_wxyz(quat_wxyz: FloatArray) -> FloatArray:
    """Rotation matrices (..., 3, 3) of unit quaternions (..., 4), scalar first.

    In numpy, since poses call it one by one: a call through torch takes ten times longer.
    """
    w, x, y, z = np.moveaxis(np.asarray(quat_wxyz, dtype=np.float64), -1, 0)
    entries = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(entries), (0, 1), (-2, -1))


def quat_wxyz_from_matrix(matrix: FloatArray) -> FloatArray:
    """Unit quaternions (..., 4), scalar first and not negative, of matrices (..., 3, 3)."""
    rotation = torch.from_numpy(np.ascontiguousarray(matrix, dtype=np.float64))
    quat_wxyz = wxyz_from_xyzw(roma.rotmat_to_unitquat(rotation).numpy())
    return np.where(quat_wxyz[..., :1] < 0.0, -quat_wxyz, quat_wxyz)


def quat_wxyz_product(first: FloatArray, second: FloatArray) -> FloatArray:
    """Hamilton product (4,) of quaternions (4,), scalar first; the second turns first."""
    scalar = first[0] * second[0] - first[1:] @ second[1:]
    vector = first[0] * second[1:] + second[0] * first[1:] + np.cross(first[1:], second[1:])
    return np.concatenate([[scalar], vector])


def matrix_from_rotvec(rotvec: FloatArray) -> FloatArray:
    """Rotation matrices (..., 3, 3) of rotation vectors (..., 3) in radians."""
    vector = torch.from_numpy(np.ascontiguousarray(rotvec, dtype=np.float64))
    matrix: FloatArray = roma.rotvec_to_rotmat(vector).numpy()
    return matrix


def tilt_angle_rad(matrix: FloatArray) -> float:
    """Angle in radians between an object's z axis and the world's z axis, 0 to pi."""
    return float(np.arccos(np.clip(np.asarray(matrix)[2, 2], -1.0, 1.0)))
