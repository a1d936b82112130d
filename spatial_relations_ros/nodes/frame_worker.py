"""The thread that perception runs on."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from spatial_relations_ros.perception.assembler import FrameAssembler
from spatial_relations_ros.perception.border import Frame

# How often it is looked whether the wait of a cloud is over, when nothing arrives.
POLL_SEC = 0.01


class FrameWorker:
    """Gives the frames of an assembler to a function, on a thread of its own.

    While the function computes, messages go on being taken in: callbacks that waited for it would
    let one pose in for each cloud, and on a busy machine poses would fall behind for ever.

    Args:
        assembler: from now on used through ``assembler`` only.
        handle: called with each frame; does not raise.
        now_ns: the clock of the assembler.
    """

    def __init__(
        self,
        assembler: FrameAssembler,
        handle: Callable[[Frame], None],
        now_ns: Callable[[], int],
    ) -> None:
        self._assembler = assembler
        self._handle = handle
        self._now_ns = now_ns
        self._changed = threading.Condition()
        self._is_closing = False
        self._thread = threading.Thread(target=self._run, name='perception', daemon=True)
        self._thread.start()

    @contextmanager
    def assembler(self) -> Iterator[FrameAssembler]:
        """The assembler, for this thread alone and for short; then looks for a frame."""
        with self._changed:
            yield self._assembler
            self._changed.notify()

    def close(self) -> None:
        """Ends the thread after the frame that it is at."""
        with self._changed:
            self._is_closing = True
            self._changed.notify()
        self._thread.join()

    def _run(self) -> None:
        while (frame := self._next()) is not None:
            self._handle(frame)

    def _next(self) -> Frame | None:
        with self._changed:
            while not self._is_closing:
                frame = self._assembler.take(self._now_ns())
                if frame is not None:
                    return frame
                self._changed.wait(POLL_SEC if self._assembler.num_clouds else None)
        return None
