"""A Kinect2's message for timing the PointCloud2 reader, and the usual way to read it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.datasets.kinect_simulator import QHD_CAMERA
from spatial_relations_ros.evaluation.cloud_fuzz import FuzzedCloud, FuzzedField

POINT_STEP = 32
RGB_OFFSET = 16
# Of the pixels of a table top in the recorded bag.
INVALID_SHARE = 0.2


def kinect_message(seed: int = 0) -> FuzzedCloud:
    """A message of 960 x 540 points as the Kinect2's driver lays it out, 16.6 MB."""
    rng = np.random.default_rng(seed)
    camera = QHD_CAMERA
    depth = rng.uniform(0.6, 2.0, (camera.height, camera.width)).astype(np.float32)
    depth[rng.random(depth.shape) < INVALID_SHARE] = np.nan
    rows = np.zeros((camera.height, camera.width, POINT_STEP // 4), dtype='<f4')
    rows[..., :3] = camera.rays() * depth[..., None]
    fields = [FuzzedField(axis, 4 * idx) for idx, axis in enumerate('xyz')]
    return FuzzedCloud(
        camera.height,
        camera.width,
        [*fields, FuzzedField('rgb', RGB_OFFSET)],
        False,
        POINT_STEP,
        POINT_STEP * camera.width,
        rows.tobytes(),
        False,
    )


def structured_points(message: Any) -> NDArray[np.float32]:
    """Finite points (N, 3) by a structured array, as ros_numpy and its successors read them.

    Right for native, unpadded rows of float32 only.
    """
    dtype = np.dtype(
        {
            'names': [item.name for item in message.fields],
            'formats': ['<f4'] * len(message.fields),
            'offsets': [item.offset for item in message.fields],
            'itemsize': message.point_step,
        }
    )
    cloud = np.frombuffer(message.data, dtype).reshape(message.height, message.width)
    finite = np.isfinite(cloud['x']) & np.isfinite(cloud['y']) & np.isfinite(cloud['z'])
    cloud = cloud[finite]
    points = np.zeros((*cloud.shape, 3), dtype=np.float32)
    for axis_idx, axis in enumerate('xyz'):
        points[..., axis_idx] = cloud[axis]
    return points
