"""What signal handlers set, at any moment of the thread that waits for it."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator

import pytest

from spatial_relations_ros.ros.stop_request import StopRequest

TIMEOUT_SEC = 60.0


@pytest.fixture
def requests_by_signal() -> Iterator[list[StopRequest]]:
    """The requests that a signal sets, some thousand times a second."""
    requests: list[StopRequest] = []

    def on_signal(*_: object) -> None:
        for request in requests:
            request.set()

    before = signal.signal(signal.SIGUSR1, on_signal)
    end = threading.Event()

    def send() -> None:
        while not end.wait(1e-4):
            os.kill(os.getpid(), signal.SIGUSR1)

    sender = threading.Thread(target=send)
    sender.start()
    yield requests
    end.set()
    sender.join()
    signal.signal(signal.SIGUSR1, before)


def test_a_signal_may_come_at_any_moment_of_the_wait(
    requests_by_signal: list[StopRequest],
) -> None:
    """With an Event the thread soon waits for itself."""
    request = StopRequest()
    requests_by_signal[:] = [request]
    end_sec = time.monotonic() + 0.5
    while time.monotonic() < end_sec:
        request.wait(1e-5)
    assert request.is_set()


def test_it_stays_set_and_is_waited_for_once(requests_by_signal: list[StopRequest]) -> None:
    request = StopRequest()
    requests_by_signal[:] = [request]
    assert request.wait(TIMEOUT_SEC)
    requests_by_signal.clear()
    for _ in range(100):
        assert request.wait()


def test_another_thread_may_set_it() -> None:
    request = StopRequest()
    assert not request.wait(0.01)
    start_sec = time.monotonic()
    threading.Timer(0.05, request.set).start()
    assert request.wait(TIMEOUT_SEC)
    assert time.monotonic() - start_sec < TIMEOUT_SEC / 2.0


def test_a_signal_that_another_thread_takes_wakes_the_main_thread() -> None:
    """The system chooses the thread; here the main one blocks the signal."""
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = {number: signal.getsignal(number) for number in numbers}
    request = StopRequest.by_signals()
    taken = threading.Event()

    def take() -> None:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGTERM])
        assert taken.wait(TIMEOUT_SEC)

    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGTERM])
    taker = threading.Thread(target=take)
    taker.start()
    sender = threading.Timer(0.1, lambda: os.kill(os.getpid(), signal.SIGTERM))
    sender.start()
    start_sec = time.monotonic()
    try:
        assert request.wait(TIMEOUT_SEC)
        # At the end of its time it would see the request too.
        assert time.monotonic() - start_sec < TIMEOUT_SEC / 2.0
    finally:
        taken.set()
        taker.join()
        sender.join()
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGTERM])
        signal.set_wakeup_fd(-1)
        for number, handler in before.items():
            signal.signal(number, handler)
