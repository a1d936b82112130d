"""Scenes as tensors, and the random views of them that a batch is made of."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import roma
import torch
from numpy.typing import NDArray
from torch import Tensor

from spatial_relations_ros.core import DatasetFormatError, Relation, Scene
from spatial_relations_ros.learning.training_config import TrainingConfig
from spatial_relations_ros.projection import apply_poses, resample_points

STORED_POINTS = 4096
_MAX_LIFT = 0.6
_MAX_TILT_RAD = math.radians(60.0)


@dataclass(frozen=True, eq=False)
class TrainingSet:
    """Labelled scenes.

    Attributes:
        clouds: (K, 4096, 3) object clouds, object frames, metres.
        object_idx: (M, 2) rows of ``clouds``: base, relative.
        rotations: (M, 2, 3, 3) world from object.
        translations: (M, 2, 3) world from object, metres.
        labels: (M,) values of :class:`Relation`.
    """

    clouds: Tensor
    object_idx: Tensor
    rotations: Tensor
    translations: Tensor
    labels: Tensor

    @staticmethod
    def from_scenes(scenes: Sequence[Scene], labels: Sequence[int]) -> TrainingSet:
        """Stacks scenes; objects of the same id must have the same cloud.

        Raises:
            DatasetFormatError: without scenes, or with a label that no other scene has.
        """
        if not scenes:
            raise DatasetFormatError('the training set has no labelled scene')
        counts = np.bincount(np.asarray(labels), minlength=len(Relation))
        lonely = [Relation(int(label)).name for label in np.flatnonzero(counts == 1)]
        if lonely:
            raise DatasetFormatError(f'only one scene of {", ".join(lonely)}; two are needed')
        rows: dict[str, int] = {}
        clouds: list[NDArray[np.float32]] = []
        for scene in scenes:
            for item in scene.objects:
                if item.object_id not in rows:
                    rows[item.object_id] = len(clouds)
                    clouds.append(resample_points(item.points, STORED_POINTS))
        poses = [[item.world_from_object for item in scene.objects] for scene in scenes]
        as_tensor = torch.from_numpy
        return TrainingSet(
            as_tensor(np.stack(clouds)),
            torch.tensor([[rows[name] for name in scene.object_ids] for scene in scenes]),
            as_tensor(np.array([[p.rotation for p in pair] for pair in poses], np.float32)),
            as_tensor(np.array([[p.translation for p in pair] for pair in poses], np.float32)),
            torch.tensor(list(labels)),
        )

    def draw_scenes(self, scenes_per_class: int, generator: torch.Generator) -> Tensor:
        """Rows of a batch with equally many scenes of each relation that occurs."""
        picks = []
        for label in torch.unique(self.labels):
            rows = torch.nonzero(self.labels == label)[:, 0]
            chosen = torch.randint(len(rows), (scenes_per_class,), generator=generator)
            if scenes_per_class <= len(rows):
                chosen = torch.randperm(len(rows), generator=generator)[:scenes_per_class]
            picks.append(rows[chosen])
        return torch.cat(picks)

    def points(self, rows: Tensor, num_points: int, generator: torch.Generator) -> Tensor:
        """World points (B, 2, num_points, 3), a random choice of each cloud."""
        choice = torch.randint(
            self.clouds.shape[1], (len(rows), 2, num_points), generator=generator
        )
        clouds = self.clouds[self.object_idx[rows][..., None], choice]
        return apply_poses(clouds, self.rotations[rows], self.translations[rows])


def augment(points: Tensor, config: TrainingConfig, generator: torch.Generator) -> Tensor:
    """Noise on both poses, rotation of the whole scene about z, and the swap of channels."""
    batch = points.shape[0]
    extent = _extents(points.flatten(1, 2)).amax(dim=-1)
    shift = torch.randn(batch, 2, 1, 3, generator=generator) * config.translation_noise
    tilt = torch.randn(batch, 2, 3, generator=generator) * config.rotation_noise_rad
    points = _rotate_about_centre(points, tilt) + shift * extent[:, None, None, None]
    yaw = torch.zeros(batch, 3)
    yaw[:, 2] = torch.rand(batch, generator=generator) * (2.0 * math.pi)
    points = points @ roma.rotvec_to_rotmat(yaw).transpose(-1, -2)[:, None]
    if config.swap_channels:
        swap = torch.rand(batch, generator=generator) < 0.5
        points = torch.where(swap[:, None, None, None], points.flip(1), points)
    return points


def lift_and_tilt(points: Tensor, generator: torch.Generator) -> tuple[Tensor, Tensor]:
    """Scenes whose relative object is lifted, sunk or tilted, and by how much.

    Such a scene has lost its relation to the degree of the change, whatever the relation was.

    Args:
        points: (B, 2, N, 3) real scenes.
        generator: source of the changes.

    Returns:
        The changed points and the change (B,), 0 (none) to 1 (as far as it goes).
    """
    batch = points.shape[0]
    amount = torch.rand(batch, generator=generator)
    sign = torch.where(torch.rand(batch, generator=generator) < 0.5, -1.0, 1.0)
    is_lift = (torch.rand(batch, generator=generator) < 0.6).to(points.dtype)
    direction = torch.rand(batch, generator=generator) * (2.0 * math.pi)
    relative = points[:, 1:]
    height = _extents(relative[:, 0]).mean(dim=-1)
    angle = (1.0 - is_lift) * amount * _MAX_TILT_RAD
    axis = torch.stack([direction.cos(), direction.sin(), torch.zeros(batch)], dim=-1)
    relative = _rotate_about_centre(relative, (axis * angle[:, None])[:, None])
    lift = torch.zeros(batch, 1, 1, 3)
    lift[..., 2] = (is_lift * sign * amount * _MAX_LIFT * height)[:, None, None]
    return torch.cat([points[:, :1], relative + lift], dim=1), amount


def _extents(points: Tensor) -> Tensor:
    return points.amax(dim=-2) - points.amin(dim=-2)


def _rotate_about_centre(points: Tensor, rotvec: Tensor) -> Tensor:
    """Turns clouds (B, K, N, 3) about the centres of their bounding boxes."""
    centre = 0.5 * (points.amax(dim=-2, keepdim=True) + points.amin(dim=-2, keepdim=True))
    rotations: Tensor = roma.rotvec_to_rotmat(rotvec)
    return (points - centre) @ rotations.transpose(-1, -2) + centre
