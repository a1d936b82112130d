"""What a signal handler may set: whether a program is to end."""

from __future__ import annotations

import contextlib
import math
import select
import signal
import socket
import time
from typing import ClassVar


class StopRequest:
    """Whether a program is to end; one thread may wait for it.

    Unlike a ``threading.Event``, whose lock a signal handler must not touch: the handler runs in
    the main thread, which waits forever for itself when the signal comes while it holds that
    lock. And unlike any lock it cannot miss a signal: Python runs handlers in the main thread
    only, which does not look for signals once it has begun to wait for a lock, and which a signal
    that another thread takes does not wake. A socket it waits at gets a byte in any case.
    """

    # Kept: every signal rings at a number of its socket, which must not become another file's.
    _by_signals: ClassVar[StopRequest | None] = None

    def __init__(self) -> None:
        self._is_set = False
        self._bell, self._ring = socket.socketpair()
        for end in (self._bell, self._ring):
            end.setblocking(False)

    @classmethod
    def by_signals(cls) -> StopRequest:
        """One that SIGINT and SIGTERM set from now on; to be called in the main thread."""
        request = cls()
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: request.set())
        # Every signal rings from now on, before its handler runs.
        signal.set_wakeup_fd(request._ring.fileno(), warn_on_full_buffer=False)
        cls._by_signals = request
        return request

    def set(self) -> None:
        """Asks for the end, from any thread or signal handler."""
        self._is_set = True
        with contextlib.suppress(OSError):  # it has rung often enough, or nobody waits any more
            self._ring.send(b'\0')

    def is_set(self) -> bool:
        """Whether the end was asked for."""
        return self._is_set

    def wait(self, timeout_sec: float | None = None) -> bool:
        """Waits until the end is asked for, or for some seconds; gives whether it was."""
        end_sec = math.inf if timeout_sec is None else time.monotonic() + timeout_sec
        while not self._is_set and (left_sec := end_sec - time.monotonic()) > 0.0:
            select.select([self._bell], [], [], None if math.isinf(left_sec) else left_sec)
            with contextlib.suppress(BlockingIOError):
                self._bell.recv(4096)
        return self._is_set
