"""Labelled scenes as tensors, from which batches are drawn."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from spatial_relations_ros.core import DatasetFormatError, Relation, Scene
from spatial_relations_ros.projection import apply_poses, resample_points

STORED_POINTS = 4096


@dataclass(frozen=True, eq=False)
class TrainingSet:
    """Labelled scenes.

    Attributes:
        clouds: (K, 4096, 3) object clouds, object frames, metres.
        object_idx: (M, 2) rows of ``clouds``: base, relative.
        rotations: (M, 2, 3, 3) world from object.
        translations: (M, 2, 3) world from object, metres.
        labels: (M,) values of :class:`Relation`.
        measures: (M, C) continuous ground truth scaled to about one, NaN where unknown.
    """

    clouds: Tensor
    object_idx: Tensor
    rotations: Tensor
    translations: Tensor
    labels: Tensor
    measures: Tensor

    @staticmethod
    def from_scenes(
        scenes: Sequence[Scene],
        labels: Sequence[int],
        measures: NDArray[np.float32] | None = None,
    ) -> TrainingSet:
        """Stacks scenes; objects of the same id must have the same cloud.

        Args:
            scenes: M scenes.
            labels: M values of :class:`Relation`.
            measures: (M, C), see the class; None when nothing is known.

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
        if measures is None:
            measures = np.full((len(scenes), 1), np.nan, dtype=np.float32)
        return TrainingSet(
            as_tensor(np.stack(clouds)),
            torch.tensor([[rows[name] for name in scene.object_ids] for scene in scenes]),
            as_tensor(np.array([[p.rotation for p in pair] for pair in poses], np.float32)),
            as_tensor(np.array([[p.translation for p in pair] for pair in poses], np.float32)),
            torch.tensor(list(labels)),
            as_tensor(np.asarray(measures, dtype=np.float32)),
        )

    def sha256(self) -> str:
        """Of all that training sees: two sets of the same hash give the same weights."""
        digest = hashlib.sha256()
        for item in dataclasses.fields(self):
            tensor = getattr(self, item.name)
            digest.update(f'{item.name} {tensor.dtype} {tuple(tensor.shape)};'.encode())
            digest.update(tensor.cpu().contiguous().numpy().tobytes())
        return digest.hexdigest()

    def to(self, device: torch.device) -> TrainingSet:
        """The same scenes in a device's memory."""
        moved = {
            item.name: getattr(self, item.name).to(device) for item in dataclasses.fields(self)
        }
        return TrainingSet(**moved)

    def draw_scenes(self, scenes_per_class: int, generator: torch.Generator) -> Tensor:
        """Rows of a batch with equally many scenes of each relation that occurs."""
        picks = []
        labels = self.labels.cpu()
        for label in torch.unique(labels):
            rows = torch.nonzero(labels == label)[:, 0]
            chosen = torch.randint(len(rows), (scenes_per_class,), generator=generator)
            if scenes_per_class <= len(rows):
                chosen = torch.randperm(len(rows), generator=generator)[:scenes_per_class]
            picks.append(rows[chosen])
        return torch.cat(picks).to(self.labels.device)

    def points(self, rows: Tensor, num_points: int, generator: torch.Generator) -> Tensor:
        """World points (B, 2, num_points, 3), a random choice of each cloud."""
        shape = (len(rows), 2, num_points)
        choice = torch.randint(self.clouds.shape[1], shape, generator=generator)
        clouds = self.clouds[self.object_idx[rows][..., None], choice.to(self.clouds.device)]
        return apply_poses(clouds, self.rotations[rows], self.translations[rows])
