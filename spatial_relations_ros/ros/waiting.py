"""Waiting in one thread for what other threads do: rclpy's futures, the worker's jobs."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future as JobFuture
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

from rclpy.task import Future

from spatial_relations_ros.core import SpatialRelationsError

Result = TypeVar('Result')

POLL_SEC = 0.02


class BusyError(SpatialRelationsError):
    """More requests wait than are served in reasonable time."""


class NoAnswerError(SpatialRelationsError):
    """A service of another node that is not there or does not answer."""


def wait_for(future: Future, timeout_sec: float) -> Any:
    """The result of an rclpy future that another thread of the executor completes.

    Raises:
        NoAnswerError: when it is not complete in time.
    """
    done = threading.Event()
    future.add_done_callback(lambda _: done.set())
    if not done.wait(timeout_sec):
        raise NoAnswerError(f'no answer within {timeout_sec:g} s')
    return future.result()


class Worker:
    """The one thread on which models run; jobs wait their turn."""

    def __init__(self, max_pending: int = 6) -> None:
        self._pool = ThreadPoolExecutor(max_workers=1, thread_name_prefix='inference')
        self._lock = threading.Lock()
        self._num_pending = 0
        self._max_pending = max_pending
        self._closing = threading.Event()

    @property
    def is_closing(self) -> bool:
        """Whether long jobs should come to an end."""
        return self._closing.is_set()

    @property
    def num_pending(self) -> int:
        """Jobs that wait or run."""
        return self._num_pending

    def submit(self, job: Callable[[], Result]) -> JobFuture[Result]:
        """Queues a job.

        Raises:
            BusyError: when too many wait already, or the worker is closing.
        """
        with self._lock:
            if self.is_closing:
                raise BusyError('the node is shutting down')
            if self._num_pending >= self._max_pending:
                raise BusyError(f'{self._num_pending} requests wait already; try again later')
            self._num_pending += 1
        future = self._pool.submit(job)
        future.add_done_callback(self._finished)
        return future

    def _finished(self, _: object) -> None:
        with self._lock:
            self._num_pending -= 1

    def run(self, job: Callable[[], Result]) -> Result:
        """Runs a job on the worker's thread and waits for its result.

        Raises:
            BusyError: as ``submit`` does; otherwise what the job raises.
        """
        return self.submit(job).result()

    def close(self) -> None:
        """Drops waiting jobs and tells the running one to end."""
        self._closing.set()
        self._pool.shutdown(wait=False, cancel_futures=True)


def wait_until(condition: Callable[[], bool], timeout_sec: float) -> bool:
    """Waits for a condition that other threads or processes bring about; False when it is late."""
    pause = threading.Event()
    end_sec = time.monotonic() + timeout_sec
    while not condition():
        if time.monotonic() >= end_sec:
            return False
        pause.wait(POLL_SEC)
    return True
