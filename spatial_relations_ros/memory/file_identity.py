"""Whether a path still leads to the file that was opened there."""

from __future__ import annotations

import os
from pathlib import Path

from spatial_relations_ros.core import MemoryFileError

MOVED = (
    'was moved, removed or replaced after it was opened; nothing was read or written, ask again '
    'or open it anew'
)


class FileIdentity:
    """The file that a path leads to now, so that another one is noticed later.

    What is written into a file that was moved away is no longer where others look for it.

    Args:
        path: of a file that has been opened.

    Raises:
        OSError: when there is none.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        # A later change of the working directory moves no file.
        self._place = path.absolute()
        self._identity = self._found()

    def is_in_place(self) -> bool:
        """Whether the path still leads there."""
        try:
            return self._found() == self._identity
        except OSError:
            return False

    def check(self) -> None:
        """Looks whether the path still leads there.

        Raises:
            MemoryFileError: when it does not.
        """
        if not self.is_in_place():
            raise MemoryFileError(f'{self._path} {MOVED}')

    def _found(self) -> tuple[int, int]:
        status = os.stat(self._place)
        return status.st_dev, status.st_ino
