"""The file of remembered relations: opening it, its tables, its errors."""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from spatial_relations_ros.core import MemoryFileError, data_path
from spatial_relations_ros.memory.damage import read_text

# "SpRl": tells this file from any other SQLite database.
APPLICATION_ID = 0x5370526C
SCHEMA_VERSION = 1
BUSY_TIMEOUT_SEC = 10.0
_RETRY_SEC = 0.01

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

    Raises:
        MemoryFileError: when it cannot be opened or is not a file of remembered relations.
    """
    with explained(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        connection = sqlite3.connect(
            path, timeout=BUSY_TIMEOUT_SEC, isolation_level=None, check_same_thread=False
        )
        try:
            _prepare(connection, path)
        except BaseException:
            connection.close()
            raise
    return connection


def _prepare(connection: sqlite3.Connection, path: Path) -> None:
    connection.text_factory = read_text
    connection.execute('PRAGMA foreign_keys = ON')
    # In one view of the file: another process may just be making it.
    with snapshot(connection):
        is_ours = _is_ours(connection, path)
    if not is_ours:
        # Readers go on while one writes; survives being killed at any moment.
        _write_ahead(connection)
        with transaction(connection):
            # Another process may have been faster.
            if not _is_ours(connection, path):
                for statement in _TABLES.split(';'):
                    connection.execute(statement)
                connection.execute(f'PRAGMA application_id = {APPLICATION_ID}')
                connection.execute(f'PRAGMA user_version = {SCHEMA_VERSION}')
    connection.execute('PRAGMA synchronous = FULL')


def _write_ahead(connection: sqlite3.Connection) -> None:
    """Changes the journal; other than statements that fails at once while others use the file."""
    end_sec = time.monotonic() + BUSY_TIMEOUT_SEC
    while True:
        try:
            connection.execute('PRAGMA journal_mode = WAL')
        except sqlite3.OperationalError as error:
            # The code's first byte; the rest tells which kind of busy.
            is_busy = error.sqlite_errorcode & 0xFF == sqlite3.SQLITE_BUSY
            if not is_busy or time.monotonic() > end_sec:
                raise
            time.sleep(_RETRY_SEC)
        else:
            return


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
    code = getattr(error, 'sqlite_errorcode', 0) & 0xFF
    if code == sqlite3.SQLITE_FULL:
        return 'the disk is full; nothing was changed'
    if code in (sqlite3.SQLITE_READONLY, sqlite3.SQLITE_PERM):
        return 'the file or its folder cannot be written; nothing was changed'
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
