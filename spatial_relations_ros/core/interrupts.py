"""How programs that start others are asked to end."""

from __future__ import annotations

import signal


def interrupt_on_signals() -> None:
    """Lets SIGINT and SIGTERM raise KeyboardInterrupt in the main thread.

    A script starts its background jobs with SIGINT ignored, and what they start ignores it too;
    SIGTERM ends a program before it can end what it started.
    """
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
