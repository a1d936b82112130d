"""Remembered relations: demonstrated scenes under names, found again by their embedding."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import (
    ConfigError,
    MemoryFileError,
    RelationExistsError,
    Scene,
    UnknownRelationError,
    WeightsError,
)
from spatial_relations_ros.memory.current_index import CurrentIndex
from spatial_relations_ros.memory.damage import DamageReport, is_storable_text
from spatial_relations_ros.memory.file_identity import FileIdentity
from spatial_relations_ros.memory.neighbours import Neighbour, checked_embedding
from spatial_relations_ros.memory.relation_rows import RememberedRelation, read_relations
from spatial_relations_ros.memory.scene_rows import check_storable, insert_objects, read_scene
from spatial_relations_ros.memory.schema import (
    default_memory_path,
    explained,
    open_database,
    snapshot,
    transaction,
)

Embed = Callable[[Sequence[Scene]], NDArray[np.float32]]
"""Embeddings (B, D) of scenes, as ``RelationMetric.embed_scenes``."""

MAX_NAME_LENGTH = 200
EMBED_BATCH = 64


class RelationMemory:
    """Demonstrated relations in one SQLite file.

    Several processes may use the file at once; a killed process leaves the last complete state.
    An object may be used from several threads; calls take turns, but none waits while another one
    embeds scenes.

    Where the file or its folder cannot be written, what is in it can still be read.

    Args:
        path: the file; made when missing. Below XDG_DATA_HOME by default.
        warn: told, once of each, which relations are damaged and left out; Python's warnings by
            default.

    Raises:
        MemoryFileError: from here and every method, when the file cannot be opened, read or
            written, or is no longer at its path; a failed write changes nothing.
    """

    def __init__(
        self, path: Path | str | None = None, *, warn: Callable[[str], None] | None = None
    ) -> None:
        self.path = default_memory_path() if path is None else Path(path)
        self._damage = DamageReport(warn or _warn)
        self._lock = threading.RLock()
        self._connection = open_database(self.path)
        with explained(self.path):
            self._identity = FileIdentity(self.path)
        self._index = CurrentIndex(self._connection)

    def close(self) -> None:
        """Closes the file; the object cannot be used afterwards."""
        with self._lock:
            self._connection.close()

    def is_in_place(self) -> bool:
        """Whether the file is still at its path; otherwise only a new object can use that."""
        return self._identity.is_in_place()

    @contextmanager
    def _use(self) -> Iterator[None]:
        """The file for one thread: the one that was opened, and its errors in words."""
        with self._lock, explained(self.path):
            self._identity.check()
            yield

    def __enter__(self) -> RelationMemory:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def remember(
        self,
        name: str,
        scene: Scene,
        embedding: NDArray[np.floating],
        model_hash: str,
        *,
        replace: bool = False,
    ) -> None:
        """Stores a relation; a name that is taken is refused unless ``replace``.

        Args:
            name: not empty, at most 200 characters, without surrounding spaces, valid UTF-8.
            scene: the demonstration; clouds, poses and meshes are kept exactly.
            embedding: (D,) of the scene.
            model_hash: of the model that made it.
            replace: whether a relation of that name is replaced.

        Raises:
            RelationExistsError: when the name is taken and not to be replaced.
            ConfigError: for a name or an embedding that cannot be stored.
            InvalidSceneError: for a scene that cannot be stored.
        """
        if not name or name != name.strip() or len(name) > MAX_NAME_LENGTH:
            raise ConfigError(
                f'{name!r} is no name for a relation; give 1 to {MAX_NAME_LENGTH} characters '
                'without surrounding spaces'
            )
        if not is_storable_text(name):
            raise ConfigError(f'{name!r} is no name for a relation: it is no valid UTF-8')
        check_storable(scene)
        vector = checked_embedding(embedding)
        with self._use():
            with transaction(self._connection):
                taken = self._id_of(name)
                if taken is not None and not replace:
                    raise RelationExistsError(
                        f'a relation {name!r} is remembered already; choose another name, '
                        'replace it or forget it first'
                    )
                self._connection.execute('DELETE FROM relations WHERE relation_id = ?', (taken,))
                row = self._connection.execute(
                    'INSERT INTO relations (name, frame_id, stamp_ns, model_hash, embedding) '
                    'VALUES (?, ?, ?, ?, ?)',
                    (name, scene.frame_id, scene.stamp_ns, model_hash, vector.tobytes()),
                )
                insert_objects(self._connection, int(row.lastrowid or 0), scene)
            if taken is not None:
                self._index.forget(taken)

    def forget(self, name: str) -> None:
        """Removes a relation.

        Raises:
            UnknownRelationError: when there is none of that name.
        """
        with self._use():
            with transaction(self._connection):
                relation_id = self._id_of(name)
                if relation_id is None:
                    raise self._unknown(name)
                self._connection.execute(
                    'DELETE FROM relations WHERE relation_id = ?', (relation_id,)
                )
            self._index.forget(relation_id)

    def get(self, name: str) -> Scene:
        """The demonstration that was remembered under a name.

        Raises:
            UnknownRelationError: when there is none of that name.
            MemoryFileError: when it is damaged.
        """
        with self._use():
            with snapshot(self._connection):
                relation_id = self._id_of(name)
                scene = None if relation_id is None else read_scene(self._connection, relation_id)
            if scene is None:
                raise self._unknown(name)
            return scene

    def list(self) -> tuple[RememberedRelation, ...]:
        """All remembered relations, by name; damaged ones are left out with a warning."""
        with self._use():
            relations, damaged = read_relations(self._connection)
        self._damage.tell(damaged)
        return relations

    def __len__(self) -> int:
        with self._use():
            count: int = self._connection.execute('SELECT COUNT(*) FROM relations').fetchone()[0]
        return count

    def nearest(
        self,
        embedding: NDArray[np.floating],
        k: int,
        model_hash: str,
        *,
        embed: Embed | None = None,
    ) -> tuple[Neighbour, ...]:
        """The k remembered relations that are most alike, nearest first; ties by name.

        Args:
            embedding: (D,) of the scene in question.
            k: how many at most.
            model_hash: of the model that made ``embedding``.
            embed: embeds scenes with that model. Relations that another model embedded are
                embedded anew with it, and kept so: 64 at a time, on this thread. What it raises
                ends the search; batches before that are kept. Damaged relations are left out
                with a warning.

        Raises:
            WeightsError: when relations were embedded by another model and ``embed`` is missing.
            ConfigError: for a k below one or an embedding of another length.
        """
        if k < 1:
            raise ConfigError(f'asked for {k} neighbours; at least one makes sense')
        vector = checked_embedding(embedding)
        with self._use():
            stale = self._index.update(model_hash, len(vector))
            if not stale:
                return self._nearest(vector, k)
        if embed is None:
            raise WeightsError(
                f'{len(stale)} of the relations in {self.path} were embedded by another model; '
                'they have to be embedded anew with this one'
            )
        for first in range(0, len(stale), EMBED_BATCH):
            self._embed_anew(stale[first : first + EMBED_BATCH], model_hash, embed)
        with self._use():
            # Who embeds with another model meanwhile takes relations away from this search.
            self._index.update(model_hash, len(vector))
            return self._nearest(vector, k)

    def _nearest(self, vector: NDArray[np.float32], k: int) -> tuple[Neighbour, ...]:
        """Of what the index has."""
        self._damage.tell(self._index.damaged)
        return self._index.embeddings.nearest(vector, k)

    def _embed_anew(self, relation_ids: Sequence[int], model_hash: str, embed: Embed) -> None:
        """Embeds relations with another model and keeps that."""
        scenes = self._readable(relation_ids, model_hash)
        if not scenes:
            return
        embeddings = embed(tuple(scenes.values()))  # takes long: nobody may have to wait for it
        rows = [
            (model_hash, checked_embedding(vector).tobytes(), relation_id)
            for relation_id, vector in zip(scenes, embeddings, strict=True)
        ]
        # An id is never used twice: a relation that was replaced meanwhile is not touched.
        with self._use(), transaction(self._connection):
            self._connection.executemany(
                'UPDATE relations SET model_hash = ?, embedding = ? WHERE relation_id = ?', rows
            )

    def _readable(self, relation_ids: Sequence[int], model_hash: str) -> dict[int, Scene]:
        """The scenes by id, of relations that are still there and of another model.

        Leaves damaged ones out.
        """
        scenes: dict[int, Scene] = {}
        damaged: dict[int, str] = {}
        with self._use(), snapshot(self._connection):
            for relation_id in relation_ids:
                if self._is_of(relation_id, model_hash):
                    continue  # another search was faster
                try:
                    scene = read_scene(self._connection, relation_id)
                except MemoryFileError as error:
                    damaged[relation_id] = str(error)
                else:
                    if scene is not None:
                        scenes[relation_id] = scene
            self._index.leave_out(damaged)
        self._damage.tell(damaged)
        return scenes

    def _is_of(self, relation_id: int, model_hash: str) -> bool:
        row = self._connection.execute(
            'SELECT 1 FROM relations WHERE relation_id = ? AND model_hash = ?',
            (relation_id, model_hash),
        ).fetchone()
        return row is not None

    def _id_of(self, name: str) -> int | None:
        try:  # a damaged name as a command line has it, so that it can be forgotten
            raw = name.encode(errors='surrogateescape')
        except UnicodeEncodeError:
            return None
        row = self._connection.execute(
            'SELECT relation_id FROM relations WHERE name = CAST(? AS TEXT)', (raw,)
        ).fetchone()
        return None if row is None else int(row[0])

    def _unknown(self, name: str) -> UnknownRelationError:
        rows = self._connection.execute('SELECT name FROM relations ORDER BY name LIMIT 8')
        known = ', '.join(repr(row[0]) for row in rows)
        return UnknownRelationError(
            f'no relation {name!r} is remembered; there are {known}'
            if known
            else f'no relation {name!r} is remembered; none is so far'
        )


def _warn(message: str) -> None:
    warnings.warn(message, stacklevel=1)
