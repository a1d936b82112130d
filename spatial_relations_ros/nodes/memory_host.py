"""Holds the file of relations for a node: opened at first use, closed when nobody uses it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from spatial_relations_ros.memory import RelationMemory


@dataclass
class _Opened:
    """An open file and how many blocks use it."""

    memory: RelationMemory
    num_users: int = 0


class MemoryHost:
    """The open file of relations, which requests on several threads share.

    Args:
        path: of the file.
        warn: told what is damaged in it, and that another file is at its path.
    """

    def __init__(self, path: Path, warn: Callable[[str], None]) -> None:
        self._path, self._warn = path, warn
        self._lock = threading.Lock()
        self._opened: _Opened | None = None

    @contextmanager
    def memory(self) -> Iterator[RelationMemory]:
        """The memory, which stays open for the block; opened anew when its file was moved.

        Raises:
            MemoryFileError: when the file cannot be opened; the next call tries again.
        """
        with self._lock:
            if self._opened is not None and not self._opened.memory.is_in_place():
                self._warn(f'{self._path} was moved, removed or replaced; it is opened anew')
                self._let_go()
            if self._opened is None:
                self._opened = _Opened(RelationMemory(self._path, warn=self._warn))
            opened = self._opened
            opened.num_users += 1
        try:
            yield opened.memory
        finally:
            with self._lock:
                opened.num_users -= 1
                self._close_unused(opened)

    def forget(self) -> None:
        """Has the file opened anew at the next use; who uses it now ends with the old one."""
        with self._lock:
            self._let_go()

    def _let_go(self) -> None:
        opened, self._opened = self._opened, None
        if opened is not None:
            self._close_unused(opened)

    def _close_unused(self, opened: _Opened) -> None:
        if opened is not self._opened and opened.num_users == 0:
            opened.memory.close()
