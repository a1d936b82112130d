"""Interrupts: held back while something must be done whole, and handed on to other programs."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator

import pytest

from spatial_relations_ros.core.interrupts import (
    interrupt_on_signals,
    interrupts_held,
    run_program,
)

NUMBERS = (signal.SIGINT, signal.SIGTERM)


@pytest.fixture(autouse=True)
def handlers() -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in NUMBERS}
    interrupt_on_signals()
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize('number', NUMBERS)
def test_a_block_is_done_whole_before_it_is_interrupted(number: signal.Signals) -> None:
    done = []

    def work() -> None:
        with interrupts_held():
            signal.raise_signal(number)
            done.append('after the signal')

    with pytest.raises(KeyboardInterrupt):
        work()
    assert done
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(number)


def test_what_fails_within_is_said_where_nothing_interrupts() -> None:
    with pytest.raises(ValueError, match='inner'), interrupts_held():
        raise ValueError('inner')


def test_ignored_signals_stay_ignored() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with interrupts_held():
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
        signal.raise_signal(signal.SIGINT)


def test_other_threads_hold_nothing() -> None:
    handlers = []

    def work() -> None:
        with interrupts_held():
            handlers.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert handlers == [signal.default_int_handler]


def test_a_program_is_interrupted_and_says_how_it_ended() -> None:
    program = """if True:
        import os, signal
        def end(*_):
            raise SystemExit(7)
        signal.signal(signal.SIGINT, end)
        os.kill(os.getppid(), signal.SIGTERM)
        signal.pause()
    """
    assert run_program([sys.executable, '-c', program]) == 7
    assert run_program([sys.executable, '-c', 'raise SystemExit(3)']) == 3
