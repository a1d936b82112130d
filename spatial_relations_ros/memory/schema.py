"""The file of remembered relations: opening it, its tables, its errors."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from spatial_relations_ros.core import MemoryFileError, data_path
from spatial_relations_ros.memory.damage import read_text
from spatial_relations_ros.memory.file_identity import MOVED

# "SpRl": tells this file from any other SQLite database.
APPLICATION_ID = 0x5370526C
SCHEMA_VERSION = 1
BUSY_TIMEOUT_SEC = 10.0

_TABLES = """
CREATE TABLE relations (
    relation_id INTEGER PRIMARY KEY AUTOINCREMENT,
    name TEXT NOT NULL UNIQUE,
    frame_id TEXT NOT NULL,
    stamp_ns INTEGER NOT NULL,
    model_hash TEXT NOT NULL,
    embedding BLOB NOT NULL
);
CREATE INDEX relations_by_model ON relations (model_hash);
CREATE TABLE objects (
    relation_id INTEGER NOT NULL REFERENCES relations ON DELETE CASCADE,
    role INTEGER NOT NULL CHECK (role IN (0, 1)),
    object_id TEXT NOT NULL,
    pose BLOB NOT NULL,
    points BLOB NOT NULL,
    source INTEGER NOT NULL,
    support REAL,
    vertices BLOB,
    triangles BLOB,
    PRIMARY KEY (relation_id, role)
) WITHOUT ROWID;
"""


def default_memory_path() -> Path:
    """Where relations are remembered unless told otherwise: below XDG_DATA_HOME."""
    return data_path('relations.sqlite3')


def open_database(path: Path) -> sqlite3.Connection:
    """Opens the file, makes it and its folder when missing.

    Where it or its folder cannot be written it is opened for reading only.

    Raises:
        MemoryFileError: when it cannot be opened or is not a file of remembered relations.
    """
    with explained(path):
        uri, may_write = path.absolute().as_uri(), not _is_read_only(path)
        if may_write:
            path.parent.mkdir(parents=True, exist_ok=True)
        connection = _connect(uri) if may_write else _connect_read_only(path, uri)
        try:
            _prepare(connection, path)
            if may_write:
                _end_write_ahead(connection)
        except BaseException:
            connection.close()
            raise
    return connection


def _is_read_only(path: Path) -> bool:
    """Whether there is a file that cannot be written: each write makes a file beside it, too."""
    places = path, path.resolve().parent
    return path.is_file() and not all(os.access(place, os.W_OK) for place in places)


def _connect(uri: str) -> sqlite3.Connection:
    return sqlite3.connect(
        uri, uri=True, timeout=BUSY_TIMEOUT_SEC, isolation_level=None, check_same_thread=False
    )


def _connect_read_only(path: Path, uri: str) -> sqlite3.Connection:
    connection = _connect(f'{uri}?mode=ro')
    try:
        connection.execute('PRAGMA user_version')
    except sqlite3.OperationalError as error:
        connection.close()
        # Of an earlier release, with a write-ahead log: reading would make files beside it. When
        # there is none, all is in the file. A file that is locked is another matter.
        is_unmakable = error.sqlite_errorcode & 0xFF in (
            sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_READONLY
        )  # fmt: skip
        if not is_unmakable or path.with_name(f'{path.name}-wal').exists():
            raise
        return _connect(f'{uri}?immutable=1')
    return connection


def _prepare(connection: sqlite3.Connection, path: Path) -> None:
    connection.text_factory = read_text
    connection.execute('PRAGMA foreign_keys = ON')
    # In one view of the file: another process may just be making it.
    with snapshot(connection):
        is_ours = _is_ours(connection, path)
    if not is_ours:
        with transaction(connection):
            # Another process may have been faster.
            if not _is_ours(connection, path):
                for statement in _TABLES.split(';'):
                    connection.execute(statement)
                connection.execute(f'PRAGMA application_id = {APPLICATION_ID}')
                connection.execute(f'PRAGMA user_version = {SCHEMA_VERSION}')
    # The end of a transaction is its journal's, which FULL may lose with the power.
    connection.execute('PRAGMA synchronous = EXTRA')


def _end_write_ahead(connection: sqlite3.Connection) -> None:
    """Has all that is remembered in the one file, so that a copy of it is whole.

    A write-ahead log, as earlier releases had, keeps it beside the file until the last process
    closes that; and it would be taken for that of another file that is put in its place.
    """
    try:
        connection.execute('PRAGMA journal_mode = DELETE')
    except sqlite3.OperationalError as error:
        # While others use the log it goes on, and the next one to open the file tries again.
        # The code's first byte; the rest tells which kind of busy.
        if error.sqlite_errorcode & 0xFF != sqlite3.SQLITE_BUSY:
            raise


def _is_ours(connection: sqlite3.Connection, path: Path) -> bool:
    """Whether the tables are there; False for an empty file."""
    application_id = connection.execute('PRAGMA application_id').fetchone()[0]
    version = connection.execute('PRAGMA user_version').fetchone()[0]
    if application_id == APPLICATION_ID:
        if version > SCHEMA_VERSION:
            raise MemoryFileError(
                f'{path} has version {version}, made by a newer release; this one reads up to '
                f'version {SCHEMA_VERSION}'
            )
        return True
    if application_id != 0 or connection.execute('SELECT 1 FROM sqlite_master').fetchone():
        raise MemoryFileError(
            f'{path} is a database of something else; name another file for the relations'
        )
    return False


@contextmanager
def transaction(connection: sqlite3.Connection) -> Iterator[None]:
    """All statements of the block or none."""
    connection.execute('BEGIN IMMEDIATE')
    try:
        yield
        connection.execute('COMMIT')
    except BaseException:
        # A failed statement may have ended the transaction already.
        if connection.in_transaction:
            connection.execute('ROLLBACK')
        raise


@contextmanager
def snapshot(connection: sqlite3.Connection) -> Iterator[None]:
    """All reads of the block see one state of the file."""
    connection.execute('BEGIN')
    try:
        yield
    finally:
        connection.execute('COMMIT')


@contextmanager
def explained(path: Path) -> Iterator[None]:
    """Turns errors of SQLite and of the file system into ones that say what to do."""
    try:
        yield
    except sqlite3.Error as error:
        raise MemoryFileError(f'{path}: {_advice(error)}') from error
    except OSError as error:
        raise MemoryFileError(f'{path}: {error.strerror or error}') from error


def _advice(error: sqlite3.Error) -> str:
    extended_code = getattr(error, 'sqlite_errorcode', 0)
    if extended_code == sqlite3.SQLITE_READONLY_DBMOVED:
        return MOVED
    code = extended_code & 0xFF
    if code == sqlite3.SQLITE_FULL:
        return 'the disk is full; nothing was changed'
    if code in (sqlite3.SQLITE_READONLY, sqlite3.SQLITE_PERM):
        return 'is read-only: the file or its folder cannot be written; nothing was changed'
    if code in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
        return f'another process kept the file locked for {BUSY_TIMEOUT_SEC:.0f} s; try again'
    if code == sqlite3.SQLITE_NOTADB:
        return 'is not a file of remembered relations; name another one'
    if code == sqlite3.SQLITE_CORRUPT:
        return 'is damaged; move it away or restore a copy'
    if code == sqlite3.SQLITE_CANTOPEN:
        return 'cannot be opened; is it a folder, or is its folder not accessible?'
    if code == sqlite3.SQLITE_IOERR:
        return f'the disk refused ({error}); nothing was changed'
    return str(error)
