"""Poses of scenes as the optimiser's tensors, and back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray

from spatial_relations_ros.core import Pose
from spatial_relations_ros.imitation.pose_optimizer import PoseBatch


def pose_tensors(
    pairs: Sequence[tuple[Pose, Pose]], origin: NDArray[np.float64]
) -> tuple[torch.Tensor, torch.Tensor]:
    """Rotations (K, 2, 3, 3) and translations (K, 2, 3), from an origin (3,), of pairs.

    Args:
        pairs: world_from_object of base and relative.
        origin: (3,) in the world, metres.
    """
    rotations = np.array([[pose.rotation for pose in pair] for pair in pairs])
    translations = np.array([[pose.translation - origin for pose in pair] for pair in pairs])
    return torch.from_numpy(rotations).float(), torch.from_numpy(translations).float()


def row_poses(batch: PoseBatch, row: int, origin: NDArray[np.float64]) -> tuple[Pose, Pose]:
    """World_from_object of base and relative in one scene of a batch."""
    rotations = batch.rotations[row].double().numpy()
    translations = batch.translations[row].double().numpy() + origin
    base, relative = (Pose.from_rotation(rotations[k], translations[k]) for k in (0, 1))
    return base, relative
