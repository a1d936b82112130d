"""psi: applying poses to batches of clouds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from torch import Tensor


def apply_poses(points: Tensor, rotations: Tensor, translations: Tensor) -> Tensor:
    """World coordinates of object clouds.

    Args:
        points: (..., N, 3) in the object frames, metres.
        rotations: (..., 3, 3) world from object.
        translations: (..., 3) world from object, metres.

    Returns:
        (..., N, 3) in the world frame.
    """
    return points @ rotations.transpose(-1, -2) + translations[..., None, :]


def resample_points(points: NDArray[np.float32], num_points: int) -> NDArray[np.float32]:
    """Exactly ``num_points`` points of a cloud, evenly over its order, always the same ones.

    A larger cloud loses points, a smaller one repeats them, which leaves its images as they are.

    Args:
        points: (N, 3), N >= 1.
        num_points: how many to return.

    Returns:
        (num_points, 3).
    """
    order = np.random.default_rng(len(points)).permutation(len(points))
    picks = order[np.arange(num_points) % len(points)]
    return points[picks]
