"""Embeddings as rows, apart from those that are damaged."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.memory.damage import damaged_text, is_storable_text

EmbeddingRow = tuple[int, str, Any]
"""Id and name of a relation, and its embedding: a blob of float32 unless it is damaged."""

_NUMBER_BYTES = 4


@dataclass(frozen=True)
class Embeddings:
    """Embeddings of one length.

    Attributes:
        ids: of the relations, (B,).
        names: of the relations, (B,).
        vectors: (B, D).
    """

    ids: Sequence[int]
    names: Sequence[str]
    vectors: NDArray[np.float32]


def usual_dim(rows: Sequence[EmbeddingRow], wanted: int) -> int:
    """How many numbers the embeddings of a model have: as many as wanted, if any has.

    Otherwise the most usual; of equally usual ones the most, as files are rather cut.
    """
    lengths = Counter(len(blob) for _, _, blob in rows if isinstance(blob, bytes))
    possible = [length for length in lengths if length and length % _NUMBER_BYTES == 0]
    if wanted * _NUMBER_BYTES in possible or not possible:
        return wanted
    return max(possible, key=lambda length: (lengths[length], length)) // _NUMBER_BYTES


def read_embeddings(rows: Sequence[EmbeddingRow], dim: int) -> tuple[Embeddings, dict[int, str]]:
    """The embeddings that can be used, and by id what is wrong with the others.

    Args:
        rows: of relations that one model has embedded.
        dim: how many numbers an embedding has.
    """
    length = dim * _NUMBER_BYTES
    damaged = {row[0]: problem for row in rows if (problem := _problem(row, length))}
    sound = [row for row in rows if row[0] not in damaged] if damaged else rows
    flat = np.frombuffer(b''.join(row[2] for row in sound), dtype='<f4')
    vectors = flat.reshape(len(sound), dim)
    is_finite = np.isfinite(vectors).all(axis=1)
    for idx in np.flatnonzero(~is_finite).tolist():
        relation_id, name, _ = sound[idx]
        damaged[relation_id] = damaged_text(
            relation_id, name, 'its embedding has numbers that are not finite'
        )
    if not is_finite.all():
        sound = [row for row, is_sound in zip(sound, is_finite, strict=True) if is_sound]
        vectors = vectors[is_finite]
    return Embeddings([row[0] for row in sound], [row[1] for row in sound], vectors), damaged


def _problem(row: EmbeddingRow, length: int) -> str:
    """What is wrong with a row beside its numbers; empty when nothing is."""
    relation_id, name, blob = row
    if not is_storable_text(name):
        return damaged_text(relation_id, name, '')
    # SQLite keeps what it is given, also in a column of blobs.
    if not isinstance(blob, bytes):
        return damaged_text(relation_id, name, 'its embedding is no blob of numbers')
    if len(blob) != length:
        return damaged_text(
            relation_id, name, f'its embedding has {len(blob)} bytes where others have {length}'
        )
    return ''
