"""Datasets as a tracker would have seen them: every pose a little wrong."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from spatial_relations_ros.core import Pose
from spatial_relations_ros.datasets.freiburg import RelationDataset, RelationScene

SHIFT_PER_RAD = 0.15
"""Standard deviation of the shift that goes with a turn by a radian, as a share of the extent."""


def with_pose_errors(dataset: RelationDataset, error_rad: float, *, seed: int) -> RelationDataset:
    """The dataset with both objects of each scene turned and shifted a little.

    Args:
        dataset: with exact poses.
        error_rad: standard deviation of the turn about each axis, about the middle of the
            object's bounding box. Upright objects of human-made scenes (Freiburg Spatial
            Relations) are tilted by 3.6 degrees in the median, which 0.053 rad gives.
        seed: of the errors.
    """
    middles = {
        name: 0.5 * (cloud.min(axis=0) + cloud.max(axis=0)).astype(np.float64)
        for name, cloud in dataset.clouds.items()
    }
    rng = np.random.default_rng(seed)
    scenes = []
    for entry in dataset.scenes:
        shift_m = SHIFT_PER_RAD * error_rad * _extent(dataset, entry)
        poses = [
            _wrong(pose, middles[name], error_rad, shift_m, rng)
            for name, pose in (
                (entry.base_id, entry.world_from_base),
                (entry.relative_id, entry.world_from_relative),
            )
        ]
        scenes.append(
            dataclasses.replace(entry, world_from_base=poses[0], world_from_relative=poses[1])
        )
    return dataclasses.replace(dataset, scenes=tuple(scenes))


def _wrong(
    pose: Pose,
    middle: NDArray[np.float64],
    error_rad: float,
    shift_m: float,
    rng: np.random.Generator,
) -> Pose:
    turn = Rotation.from_rotvec(rng.normal(0.0, error_rad, 3)).as_matrix()
    stays = pose.rotation @ middle + pose.translation
    rotation = turn @ pose.rotation
    return Pose.from_rotation(rotation, stays - rotation @ middle + rng.normal(0.0, shift_m, 3))


def _extent(dataset: RelationDataset, entry: RelationScene) -> float:
    """The longest side of the bounding box of both, metres."""
    points = np.concatenate([item.world_points for item in dataset.scene_of(entry).objects])
    return float(np.ptp(points, axis=0).max())
