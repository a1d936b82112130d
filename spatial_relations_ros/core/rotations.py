"""Quaternion orders and rotation matrices.

The core writes quaternions scalar first (``quat_wxyz``); ROS messages and roma write them scalar
last (``quat_xyzw``). These two functions are the only places where the order changes.

Without torch: what only looks at clouds shall not load it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

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
    quat = np.asarray(quat_wxyz, dtype=np.float64)
    # Of a single one numbers of Python's own are the fastest.
    w, x, y, z = quat.tolist() if quat.ndim == 1 else (quat[..., k] for k in range(4))
    entries = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    matrices = np.array(entries)
    return matrices if quat.ndim == 1 else np.moveaxis(matrices, (0, 1), (-2, -1))


def quat_wxyz_from_matrix(matrix: FloatArray) -> FloatArray:
    """Unit quaternion (4,), scalar first and not negative, of a rotation matrix (3, 3).

    The longest row of 4 q q^T, whose entries are linear in the matrix's. In numbers of Python for
    the same reason as above.
    """
    (a, b, c), (d, e, f), (g, h, i) = np.asarray(matrix, dtype=np.float64).tolist()
    products = (
        (1.0 + a + e + i, h - f, c - g, d - b),
        (h - f, 1.0 + a - e - i, b + d, c + g),
        (c - g, b + d, 1.0 - a + e - i, f + h),
        (d - b, c + g, f + h, 1.0 - a - e + i),
    )
    longest = np.array(products[max(range(4), key=lambda k: products[k][k])])
    quat_wxyz: FloatArray = longest / np.linalg.norm(longest)
    return -quat_wxyz if quat_wxyz[0] < 0.0 else quat_wxyz


def quat_wxyz_product(first: FloatArray, second: FloatArray) -> FloatArray:
    """Hamilton product (4,) of quaternions (4,), scalar first; the second turns first."""
    w, x, y, z = first.tolist()
    a, b, c, d = second.tolist()
    return np.array(
        [
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c - x * d + y * a + z * b,
            w * d + x * c - y * b + z * a,
        ]
    )


def matrix_from_rotvec(rotvec: FloatArray) -> FloatArray:
    """Rotation matrices (..., 3, 3) of rotation vectors (..., 3) in radians."""
    vectors = np.asarray(rotvec, dtype=np.float64)
    # Older releases of SciPy take one batch dimension only.
    matrices = Rotation.from_rotvec(vectors.reshape(-1, 3)).as_matrix()
    return np.asarray(matrices.reshape(*vectors.shape[:-1], 3, 3))


def tilt_angle_rad(matrix: FloatArray) -> float:
    """Angle in radians between an object's z axis and the world's z axis, 0 to pi."""
    return float(np.arccos(np.clip(np.asarray(matrix)[2, 2], -1.0, 1.0)))
