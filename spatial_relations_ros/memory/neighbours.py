"""The nearest of many embeddings, by one matrix product."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError, MemoryFileError
from spatial_relations_ros.memory.scene_rows import read_blob


@dataclass(frozen=True)
class Neighbour:
    """A remembered relation and its distance under the metric."""

    name: str
    distance: float


@dataclass(frozen=True, eq=False)
class EmbeddingIndex:
    """Embeddings of one model.

    Attributes:
        names: N of them.
        centre: (D,) their mean.
        offsets: (N, D) from the mean.
        squares: (N,) squared lengths of the offsets.
    """

    names: tuple[str, ...]
    centre: NDArray[np.float64]
    offsets: NDArray[np.float32]
    squares: NDArray[np.float32]

    @staticmethod
    def from_rows(rows: Sequence[tuple[str, bytes]]) -> EmbeddingIndex:
        """An index of names and float32 blobs.

        Raises:
            MemoryFileError: when the blobs differ in length.
        """
        if len({len(blob) for _, blob in rows}) > 1:
            raise MemoryFileError('stored embeddings of one model differ in length')
        flat = read_blob(b''.join(blob for _, blob in rows), '<f4')
        embeddings = flat.reshape(len(rows), -1) if rows else np.zeros((0, 0), dtype=np.float32)
        # A common offset would cost the products below their precision.
        centre = embeddings.mean(axis=0, dtype=np.float64) if rows else np.zeros(0)
        offsets = (embeddings - centre).astype(np.float32)
        squares = np.einsum('nd,nd->n', offsets, offsets)
        return EmbeddingIndex(tuple(name for name, _ in rows), centre, offsets, squares)

    def nearest(self, embedding: NDArray[np.float32], k: int) -> tuple[Neighbour, ...]:
        """The k nearest, nearest first; equally near ones in the order of the names given.

        Raises:
            ConfigError: for an embedding (D,) of another length.
        """
        if not self.names:
            return ()
        if len(self.centre) != len(embedding):
            raise ConfigError(
                f'the embedding has {len(embedding)} numbers, the remembered ones have '
                f'{len(self.centre)}'
            )
        wanted = embedding - self.centre
        # The product ranks all, but loses small distances to cancellation: differences give the
        # exact distances of the few candidates.
        ranks = self.squares - 2.0 * (self.offsets @ wanted.astype(np.float32))
        num_candidates = min(len(self.names), 2 * k + 16)
        candidates = np.argpartition(ranks, num_candidates - 1)[:num_candidates]
        candidates.sort()
        distances = np.linalg.norm(self.offsets[candidates] - wanted, axis=1)
        order = np.argsort(distances, kind='stable')[:k]
        return tuple(
            Neighbour(self.names[candidates[row]], float(distances[row])) for row in order
        )


def checked_embedding(embedding: NDArray[np.floating]) -> NDArray[np.float32]:
    """The embedding as (D,) float32, little-endian and contiguous.

    Raises:
        ConfigError: when it is empty, not finite or no vector.
    """
    vector = np.ascontiguousarray(embedding, dtype='<f4')
    if vector.ndim != 1 or len(vector) == 0 or not np.isfinite(vector).all():
        raise ConfigError(f'an embedding is (D,) finite numbers, got {vector.shape}')
    return vector
