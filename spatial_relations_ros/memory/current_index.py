"""Keeps the embeddings in memory as they are in the file, whoever writes it."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Sequence

import numpy as np

from spatial_relations_ros.memory.embedding_rows import read_embeddings, usual_dim
from spatial_relations_ros.memory.neighbours import EmbeddingIndex
from spatial_relations_ros.memory.schema import snapshot


class CurrentIndex:
    """The index of a file's embeddings, read again only as far as the file has changed.

    Ids of relations rise and are never used twice, and an embedding belongs to its relation and
    model: what was read stays right until its relation is gone or another model comes.

    Args:
        connection: to the file.

    Attributes:
        embeddings: of the model that was last asked for.
        damaged: ids of relations whose embedding by that model cannot be used, and why.
    """

    def __init__(self, connection: sqlite3.Connection) -> None:
        self.embeddings = EmbeddingIndex()
        self.damaged: dict[int, str] = {}
        self._connection = connection
        self._left_out: set[int] = set()
        # Model and length of embeddings; None has all read again.
        self._asked: tuple[str, int] | None = None
        self._last_id = 0
        self._version: tuple[int, int] | None = None

    def forget(self, relation_id: int) -> None:
        """Tells that this connection has removed a relation: saves looking for what is gone."""
        self._remove([relation_id])

    def leave_out(self, relation_ids: Iterable[int]) -> None:
        """Tells that relations cannot be embedded anew, so that nobody tries again."""
        self._left_out.update(relation_ids)

    def update(self, model_hash: str, dim: int) -> list[int]:
        """Follows the file: ``embeddings`` are then those of all that a model has embedded.

        Args:
            model_hash: of the model.
            dim: how many numbers its embeddings have.

        Returns:
            Ids of the relations that another model has embedded and that are not left out.
        """
        if self._asked == (model_hash, dim) and self._version == self._current_version():
            return []
        stale = [one for one in self._read(model_hash, dim) if one not in self._left_out]
        if stale:
            # Embedded anew they come to stand among what was read: then all is read again.
            self._asked = None
        return stale

    def _current_version(self) -> tuple[int, int]:
        """Changes whenever another connection or this one has changed the file."""
        others = self._connection.execute('PRAGMA data_version').fetchone()[0]
        return others, self._connection.total_changes

    def _read(self, model_hash: str, dim: int) -> list[int]:
        """Reads what is new; returns the ids that another model has embedded."""
        with snapshot(self._connection):
            # Two ranges of an index; an inequality would look at every row.
            stale = self._connection.execute(
                'SELECT relation_id FROM relations WHERE model_hash < ? OR model_hash > ?',
                (model_hash, model_hash),
            ).fetchall()
            is_usable = self.embeddings.dim == dim and not self.embeddings.is_sparse
            if self._asked != (model_hash, dim) or not is_usable:
                self.embeddings, self.damaged, self._last_id = EmbeddingIndex(), {}, 0
                self._asked, self._version = (model_hash, dim), None
            self._add_new(model_hash, dim)
            (count,) = self._connection.execute('SELECT COUNT(*) FROM relations').fetchone()
            if count - len(stale) != len(self.embeddings) + len(self.damaged):
                self._remove(self._gone())
            # At the end: what fails before is read again at the next call.
            self._version = self._current_version()
        return sorted(row[0] for row in stale)

    def _add_new(self, model_hash: str, dim: int) -> None:
        """Reads the relations that came after the last one that was read."""
        rows = self._connection.execute(
            'SELECT relation_id, name, embedding FROM relations '
            'WHERE relation_id > ? AND +model_hash = ? ORDER BY relation_id',
            (self._last_id, model_hash),
        ).fetchall()
        if rows:
            sound, damaged = read_embeddings(rows, self.embeddings.dim or usual_dim(rows, dim))
            self.embeddings.add(sound)
            self.damaged.update(damaged)
            self._last_id = rows[-1][0]

    def _remove(self, relation_ids: Sequence[int]) -> None:
        self.embeddings.remove(relation_ids)
        for relation_id in relation_ids:
            self.damaged.pop(relation_id, None)

    def _gone(self) -> list[int]:
        """Ids in the index that are no longer in the file."""
        # One string: a hundred thousand rows would take Python several times as long.
        (text,) = self._connection.execute(
            'SELECT group_concat(relation_id) FROM relations'
        ).fetchone()
        is_there = np.zeros(self._last_id + 1, dtype=bool)
        there = np.fromstring(text or '', dtype=np.int64, sep=',')
        is_there[there[there <= self._last_id]] = True
        known = np.append(self.embeddings.ids(), np.array([*self.damaged], dtype=np.int64))
        found: list[int] = known[~is_there[known]].tolist()
        return found
