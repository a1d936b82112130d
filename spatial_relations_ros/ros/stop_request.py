"""What a signal handler may set: whether a program is to end."""

from __future__ import annotations

import contextlib
import signal
from queue import Empty, SimpleQueue


class StopRequest:
    """Whether a program is to end; one thread may wait for it.

    Like ``threading.Event``, whose lock a signal handler must not touch: the handler runs in the
    main thread, which waits forever for itself when the signal comes while it holds that lock.
    ``SimpleQueue.put`` may be called at any moment.
    """

    def __init__(self) -> None:
        self._is_set = False
        self._wake = SimpleQueue[None]()

    @classmethod
    def by_signals(cls) -> StopRequest:
        """One that SIGINT and SIGTERM set from now on; to be called in the main thread."""
        request = cls()
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: request.set())
        return request

    def set(self) -> None:
        """Asks for the end, from any thread or signal handler."""
        self._is_set = True
        self._wake.put(None)

    def is_set(self) -> bool:
        """Whether the end was asked for."""
        return self._is_set

    def wait(self, timeout_sec: float | None = None) -> bool:
        """Waits until the end is asked for, or for some seconds; gives whether it was."""
        if not self._is_set:
            with contextlib.suppress(Empty):
                self._wake.get(timeout=timeout_sec)
        return self._is_set
