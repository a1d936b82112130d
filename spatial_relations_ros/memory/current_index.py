"""Keeps the embeddings in memory as they are in the file, whoever writes it."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import Scene, WeightsError
from spatial_relations_ros.memory.neighbours import EmbeddingIndex, checked_embedding
from spatial_relations_ros.memory.scene_rows import read_scene
from spatial_relations_ros.memory.schema import snapshot, transaction

Embed = Callable[[Sequence[Scene]], NDArray[np.float32]]
"""Embeddings (B, D) of scenes, as ``RelationMetric.embed_scenes``."""

EMBED_BATCH = 64


class CurrentIndex:
    """The index of a file's embeddings, read again only as far as the file has changed.

    Ids of relations rise and are never used twice, and an embedding belongs to its relation and
    model: what was read stays right until its relation is gone or another model comes.

    Args:
        connection: to the file.
        path: of the file, for messages.
    """

    def __init__(self, connection: sqlite3.Connection, path: Path) -> None:
        self._connection = connection
        self._path = path
        self._index = EmbeddingIndex()
        self._model_hash: str | None = None
        self._version: tuple[int, int] | None = None

    def forget(self, relation_id: int) -> None:
        """Tells that this connection has removed a relation: saves looking for what is gone."""
        self._index.remove([relation_id])

    def get(self, model_hash: str, embed: Embed | None) -> EmbeddingIndex:
        """All remembered relations, as embedded by a model.

        Raises:
            WeightsError: when relations were embedded by another model and ``embed`` is missing.
        """
        if model_hash == self._model_hash and self._version == self._current_version():
            return self._index
        stale = self._update(model_hash)
        if stale:
            self._model_hash = None
            if embed is None:
                raise WeightsError(
                    f'{len(stale)} of the relations in {self._path} were embedded by another '
                    'model; they have to be embedded anew with this one'
                )
            for first in range(0, len(stale), EMBED_BATCH):
                self._renew(stale[first : first + EMBED_BATCH], model_hash, embed)
            if self._update(model_hash):
                # A process with another model is at work: the next call reads all again.
                self._model_hash = None
        return self._index

    def _current_version(self) -> tuple[int, int]:
        """Changes whenever another connection or this one has changed the file."""
        others = self._connection.execute('PRAGMA data_version').fetchone()[0]
        return others, self._connection.total_changes

    def _update(self, model_hash: str) -> list[int]:
        """Follows the file; returns the ids that another model has embedded, if there are any."""
        with snapshot(self._connection):
            # Two ranges of an index; an inequality would look at every row.
            stale = self._connection.execute(
                'SELECT relation_id FROM relations WHERE model_hash < ? OR model_hash > ?',
                (model_hash, model_hash),
            ).fetchall()
            if self._model_hash != model_hash or self._index.is_sparse:
                self._index, self._model_hash = EmbeddingIndex(), model_hash
            self._version = self._current_version()
            self._index.add(
                self._connection.execute(
                    'SELECT relation_id, name, embedding FROM relations '
                    'WHERE relation_id > ? AND +model_hash = ? ORDER BY relation_id',
                    (self._index.last_id, model_hash),
                ).fetchall()
            )
            (count,) = self._connection.execute('SELECT COUNT(*) FROM relations').fetchone()
            if count - len(stale) != len(self._index):
                self._index.remove(self._gone())
        return sorted(row[0] for row in stale)

    def _gone(self) -> list[int]:
        """Ids in the index that are no longer in the file."""
        # One string: a hundred thousand rows would take Python several times as long.
        (text,) = self._connection.execute(
            'SELECT group_concat(relation_id) FROM relations'
        ).fetchone()
        is_there = np.zeros(self._index.last_id + 1, dtype=bool)
        there = np.fromstring(text or '', dtype=np.int64, sep=',')
        is_there[there[there <= self._index.last_id]] = True
        known = self._index.ids()
        found: list[int] = known[~is_there[known]].tolist()
        return found

    def _renew(self, relation_ids: Sequence[int], model_hash: str, embed: Embed) -> None:
        """Embeds relations anew and keeps that."""
        with snapshot(self._connection):
            scenes = {
                relation_id: scene
                for relation_id in relation_ids
                if (scene := read_scene(self._connection, relation_id)) is not None
            }
        embeddings = embed(tuple(scenes.values()))
        # An id is never used twice: a relation that was replaced meanwhile is not touched.
        with transaction(self._connection):
            self._connection.executemany(
                'UPDATE relations SET model_hash = ?, embedding = ? WHERE relation_id = ?',
                [
                    (model_hash, checked_embedding(vector).tobytes(), relation_id)
                    for relation_id, vector in zip(scenes, embeddings, strict=True)
                ],
            )
