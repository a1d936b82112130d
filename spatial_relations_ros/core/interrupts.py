"""How programs that start others are asked to end, and end them."""

from __future__ import annotations

import signal
import subprocess
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


def interrupt_on_signals() -> None:
    """Lets SIGINT and SIGTERM raise KeyboardInterrupt in the main thread.

    A script starts its background jobs with SIGINT ignored, and what they start ignores it too;
    SIGTERM ends a program before it can end what it started.
    """
    for number in _SIGNALS:
        signal.signal(number, signal.default_int_handler)


@contextmanager
def interrupts_held() -> Iterator[None]:
    """What would interrupt the block interrupts at its end, so that the block is done whole.

    A process that is started is known to who ends it only after a few more steps: interrupted
    between them it would be left. Elsewhere than in the main thread nothing is interrupted.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    # Signals that are ignored stay so: processes that are started within inherit it.
    usual = {
        number: handler for number in _SIGNALS if callable(handler := signal.getsignal(number))
    }
    for number in usual:
        signal.signal(number, lambda number, _: came.append(number))
    try:
        yield
    finally:
        for number, handler in usual.items():
            signal.signal(number, handler)
        for late in came:
            signal.raise_signal(late)


def run_program(command: Sequence[str]) -> int:
    """Runs another program to its end and hands interrupts on to it; gives its exit code.

    From now on SIGINT and SIGTERM are interrupts.
    """
    interrupt_on_signals()
    process: subprocess.Popen[bytes] | None = None
    while True:
        try:
            if process is None:
                with interrupts_held():
                    process = subprocess.Popen(command)
            return process.wait()
        except KeyboardInterrupt:
            if process is None:
                raise
            # In a terminal it got the signal already; it does not mind another one.
            process.send_signal(signal.SIGINT)
