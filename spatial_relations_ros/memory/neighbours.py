"""The nearest of many embeddings, by one matrix product."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.memory.embedding_rows import Embeddings


@dataclass(frozen=True)
class Neighbour:
    """A remembered relation and its distance under the metric."""

    name: str
    distance: float


class EmbeddingIndex:
    """Embeddings of one model, with room to grow; rows are only ever added or emptied."""

    def __init__(self) -> None:
        self._rows: dict[int, int] = {}
        self._names: list[str] = []
        self._centre: NDArray[np.float64] = np.zeros(0)
        # From the centre: a common offset would cost the products below their precision.
        self._offsets: NDArray[np.float32] = np.zeros((0, 0), dtype=np.float32)
        self._squares: NDArray[np.float32] = np.zeros(0, dtype=np.float32)

    def __len__(self) -> int:
        return len(self._rows)

    @property
    def is_sparse(self) -> bool:
        """Whether most rows have been emptied, so that a new index is worth its time."""
        is_small = len(self._names) < 1000
        return 2 * len(self._rows) < len(self._names) and not (is_small and self._rows)

    @property
    def dim(self) -> int:
        """How many numbers an embedding in it has; 0 before there is one."""
        return len(self._centre)

    def ids(self) -> NDArray[np.int64]:
        """Of all relations in it, in no order."""
        return np.fromiter(self._rows, dtype=np.int64, count=len(self._rows))

    def add(self, relations: Embeddings) -> None:
        """Adds relations, with as many numbers as those before."""
        if not relations.ids:
            return
        if not self._names:
            self._centre = relations.vectors.mean(axis=0, dtype=np.float64)
        first, after = len(self._names), len(self._names) + len(relations.ids)
        self._reserve(after)
        offsets = (relations.vectors - self._centre).astype(np.float32)
        self._offsets[first:after] = offsets
        self._squares[first:after] = np.einsum('nd,nd->n', offsets, offsets)
        self._rows.update(zip(relations.ids, range(first, after), strict=True))
        self._names.extend(relations.names)

    def remove(self, relation_ids: Iterable[int]) -> None:
        """Empties the rows of relations; ids that are not there do not matter."""
        for relation_id in relation_ids:
            row = self._rows.pop(relation_id, None)
            if row is not None:
                self._squares[row] = np.inf

    def _reserve(self, num_rows: int) -> None:
        if num_rows <= len(self._squares):
            return
        num_rows = max(num_rows, len(self._squares) * 3 // 2)
        offsets = np.zeros((num_rows, len(self._centre)), dtype=np.float32)
        squares = np.full(num_rows, np.inf, dtype=np.float32)
        used = len(self._names)
        if used:
            offsets[:used], squares[:used] = self._offsets[:used], self._squares[:used]
        self._offsets, self._squares = offsets, squares

    def nearest(self, embedding: NDArray[np.float32], k: int) -> tuple[Neighbour, ...]:
        """The k nearest, nearest first; equally near ones by name.

        Raises:
            ConfigError: for an embedding (D,) of another length.
        """
        if not self._rows:
            return ()
        if len(self._centre) != len(embedding):
            raise ConfigError(
                f'the embedding has {len(embedding)} numbers, the remembered ones have '
                f'{len(self._centre)}'
            )
        used = len(self._names)
        wanted = embedding - self._centre
        # The product ranks all, but loses small distances to cancellation: differences give the
        # exact distances of the few candidates.
        ranks = self._squares[:used] - 2.0 * (self._offsets[:used] @ wanted.astype(np.float32))
        num_candidates = min(len(self._rows), 2 * k + 16)
        candidates = np.argpartition(ranks, num_candidates - 1)[:num_candidates]
        distances = np.linalg.norm(self._offsets[candidates] - wanted, axis=1)
        found = sorted(
            (float(distance), self._names[row])
            for distance, row in zip(distances, candidates, strict=True)
        )
        return tuple(Neighbour(name, distance) for distance, name in found[:k])


def checked_embedding(embedding: NDArray[np.floating]) -> NDArray[np.float32]:
    """The embedding as (D,) float32, little-endian and contiguous.

    Raises:
        ConfigError: when it is empty, not finite or no vector.
    """
    vector = np.ascontiguousarray(embedding, dtype='<f4')
    if vector.ndim != 1 or len(vector) == 0 or not np.isfinite(vector).all():
        raise ConfigError(f'an embedding is (D,) finite numbers, got {vector.shape}')
    return vector
