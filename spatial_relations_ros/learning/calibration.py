"""What distances and embeddings of a metric mean: the same relation or not, known or not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from spatial_relations_ros.core import WeightsError

PREFIX = 'calibration.'
PRIOR = 0.5


@dataclass(frozen=True, eq=False)
class Calibration:
    """Measured on held-out scenes after training; it is stored with the weights.

    Probabilities are for a prior of one half: before looking, the same relation is as likely as
    another one.

    Attributes:
        distances: (K,) float64, rising.
        probabilities: (K,) float64, 0 to 1, never rising: that two scenes at that distance show
            the same relation; linear between, constant outside.
        prototypes: (P, D) float32, where the embeddings of the training scenes are.
        novelty_distance: an embedding that is farther from every prototype is novel.

    Raises:
        WeightsError: for arrays that do not fit together, or numbers that are none of these.
    """

    distances: NDArray[np.float64]
    probabilities: NDArray[np.float64]
    prototypes: NDArray[np.float32]
    novelty_distance: float

    def __post_init__(self) -> None:
        fits = (
            self.distances.ndim == 1
            and self.distances.shape == self.probabilities.shape
            and len(self.distances) >= 2
            and self.prototypes.ndim == 2
            and len(self.prototypes) >= 1
        )
        if not fits or not self._makes_sense():
            raise WeightsError(
                f'a calibration of {self.distances.shape} distances, {self.probabilities.shape} '
                f'probabilities, {self.prototypes.shape} prototypes and novelty distance '
                f'{self.novelty_distance} cannot be used; make it anew by training'
            )

    def _makes_sense(self) -> bool:
        """Whether the numbers are such as the class describes; nothing that is not finite is."""
        shares = self.probabilities
        return bool(
            np.isfinite(self.distances).all()
            and (np.diff(self.distances) > 0.0).all()
            and ((shares >= 0.0) & (shares <= 1.0)).all()
            and (np.diff(shares) <= 0.0).all()
            and np.isfinite(self.prototypes).all()
            and 0.0 < self.novelty_distance < np.inf
        )

    @property
    def same_relation_distance(self) -> float:
        """Scenes that are nearer than this rather show the same relation than not."""
        # Reversed since np.interp wants rising values; equal ones are nudged apart.
        ramp = np.arange(len(self.distances)) * 1e-12
        return float(np.interp(PRIOR, self.probabilities[::-1] + ramp, self.distances[::-1]))

    def same_relation_probability(self, distance: float) -> float:
        """That two scenes at this distance show the same relation, 0 to 1."""
        return float(np.interp(distance, self.distances, self.probabilities))

    def novelty(self, embeddings: NDArray[np.floating]) -> NDArray[np.float64]:
        """How far embeddings (..., D) are from everything known; above 1 is novel.

        The distance to the nearest prototype over ``novelty_distance``, shape (...).
        """
        embeddings = np.asarray(embeddings, dtype=np.float64)
        prototypes = self.prototypes.astype(np.float64)
        squared = (
            np.square(embeddings).sum(axis=-1, keepdims=True)
            + np.square(prototypes).sum(axis=-1)
            - 2.0 * embeddings @ prototypes.T
        )
        nearest = np.sqrt(np.maximum(squared.min(axis=-1), 0.0))
        return np.asarray(nearest / self.novelty_distance)

    def is_novel(self, embedding: NDArray[np.floating]) -> bool:
        """Whether an embedding (D,) is unlike everything that the metric was trained with."""
        # Written so that an embedding that is not finite is novel too.
        return not bool(self.novelty(embedding) <= 1.0)

    def tensors(self) -> dict[str, Tensor]:
        """For a safetensors file, beside the weights."""
        arrays = {
            'distances': self.distances,
            'probabilities': self.probabilities,
            'prototypes': self.prototypes,
            'novelty_distance': np.array([self.novelty_distance]),
        }
        return {
            PREFIX + name: torch.from_numpy(np.ascontiguousarray(array))
            for name, array in arrays.items()
        }

    @staticmethod
    def of_tensors(tensors: Mapping[str, Tensor]) -> Calibration | None:
        """Out of those of a file; None where it holds no calibration.

        Raises:
            WeightsError: when a part of it is missing or makes no sense.
        """
        found = {
            name.removeprefix(PREFIX): tensor.numpy()
            for name, tensor in tensors.items()
            if name.startswith(PREFIX)
        }
        if not found:
            return None
        try:
            return Calibration(
                found['distances'],
                found['probabilities'],
                found['prototypes'],
                float(found['novelty_distance'][0]),
            )
        except (KeyError, IndexError) as error:
            raise WeightsError(f'the calibration in the weights lacks {error}') from error
