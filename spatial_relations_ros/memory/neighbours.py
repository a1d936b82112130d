"""The nearest of many embeddings, by one matrix product."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
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


class EmbeddingIndex:
    """Embeddings of one model, with room to grow; rows are only ever added or emptied."""

    def __init__(self) -> None:
        self._rows: dict[int, int] = {}
        self._names: list[str] = []
        self._centre: NDArray[np.float64] = np.zeros(0)
        # From the centre: a common offset would cost the products below their precision.
        self._offsets: NDArray[np.float32] = np.zeros((0, 0), dtype=np.float32)
        self._squares: NDArray[np.float32] = np.zeros(0, dtype=np.float32)
        self.last_id = 0

    def __len__(self) -> int:
        return len(self._rows)

    @property
    def is_sparse(self) -> bool:
        """Whether most rows have been emptied, so that a new index is worth its time."""
        is_small = len(self._names) < 1000
        return 2 * len(self._rows) < len(self._names) and not (is_small and self._rows)

    def ids(self) -> NDArray[np.int64]:
        """Of all relations in it, in no order."""
        return np.fromiter(self._rows, dtype=np.int64, count=len(self._rows))

    def add(self, relations: Sequence[tuple[int, str, bytes]]) -> None:
        """Adds relations: id, name, embedding as a blob of float32; ids must rise.

        Raises:
            MemoryFileError: when a blob has another length than the others.
        """
        if not relations:
            return
        lengths = Counter(len(blob) for _, _, blob in relations)
        usual = 4 * len(self._centre) if self._names else lengths.most_common(1)[0][0]
        for _, name, blob in relations if set(lengths) != {usual} else ():
            if len(blob) != usual:
                raise MemoryFileError(
                    f'the embedding of {name!r} is damaged: {len(blob)} bytes where the others '
                    f'have {usual}; forget that relation or remember it anew'
                )
        flat = read_blob(b''.join(blob for _, _, blob in relations), '<f4')
        embeddings = flat.reshape(len(relations), -1)
        if not self._names:
            self._centre = embeddings.mean(axis=0, dtype=np.float64)
        first, after = len(self._names), len(self._names) + len(relations)
        self._reserve(after)
        offsets = (embeddings - self._centre).astype(np.float32)
        self._offsets[first:after] = offsets
        self._squares[first:after] = np.einsum('nd,nd->n', offsets, offsets)
        for row, (relation_id, name, _) in enumerate(relations, start=first):
            self._rows[relation_id] = row
            self._names.append(name)
        self.last_id = relations[-1][0]

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
