"""Waiting in one thread for what other threads do: rclpy's futures, the worker's jobs."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import CancelledError, ThreadPoolExecutor
from concurrent.futures import Future as JobFuture
from typing import Any, TypeVar

from rclpy.executors import Executor
from rclpy.task import Future

from spatial_relations_ros.core import SpatialRelationsError

Result = TypeVar('Result')

POLL_SEC = 0.02
# How often who waits asks whether to go on.
ASK_SEC = 0.1
SHUTTING_DOWN = 'the node is shutting down'


class BusyError(SpatialRelationsError):
    """More requests wait than are served in reasonable time."""


class NoAnswerError(SpatialRelationsError):
    """A service of another node that is not there or does not answer."""


def wait_for(
    future: Future, timeout_sec: float, is_over: Callable[[], bool] = lambda: False
) -> Any:
    """The result of an rclpy future that another thread of the executor completes.

    Args:
        future: of a request.
        timeout_sec: longest wait.
        is_over: whether nobody wants the result any more, asked now and then.

    Raises:
        NoAnswerError: when it is not complete in time, or the wait is over.
    """
    done = threading.Event()
    future.add_done_callback(lambda _: done.set())
    end_sec = time.monotonic() + timeout_sec
    while not done.wait(max(0.0, min(ASK_SEC, end_sec - time.monotonic()))):
        if is_over():
            raise NoAnswerError(SHUTTING_DOWN)
        if time.monotonic() >= end_sec:
            raise NoAnswerError(f'no answer within {timeout_sec:g} s')
    return future.result()


def sent_by(executor: Executor, send: Callable[[], Future], timeout_sec: float) -> Future:
    """The future of what an action client sends, sent on the executor's own thread.

    Sent on another thread, a request may be answered before the client knows of it, and the
    answer is lost (https://github.com/ros2/rclpy/issues/1123).

    Args:
        executor: of one thread, that the client's node belongs to; another thread spins it.
        send: ``send_goal_async`` of the client for instance.
        timeout_sec: until it is sent.

    Raises:
        NoAnswerError: when the executor does not come to it in time.
    """
    sent: Future = wait_for(executor.create_task(send), timeout_sec)
    return sent


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

    def submit(self, job: Callable[[], Result], *, goes_on: bool = False) -> JobFuture[Result]:
        """Queues a job.

        Args:
            job: to run.
            goes_on: whether it belongs to something that has begun, and is not refused however
                many wait.

        Raises:
            BusyError: when too many wait already, or the worker is closing.
        """
        with self._lock:
            if self.is_closing:
                raise BusyError(SHUTTING_DOWN)
            if self._num_pending >= self._max_pending and not goes_on:
                raise BusyError(f'{self._num_pending} requests wait already; try again later')
            self._num_pending += 1
            future = self._pool.submit(job)
        future.add_done_callback(self._finished)
        return future

    def _finished(self, _: object) -> None:
        with self._lock:
            self._num_pending -= 1

    def run(self, job: Callable[[], Result], *, goes_on: bool = False) -> Result:
        """Runs a job on the worker's thread and waits for its result.

        Raises:
            BusyError: as ``submit`` does, or when the job was dropped because the worker closes;
                otherwise what the job raises.
        """
        try:
            return self.submit(job, goes_on=goes_on).result()
        except CancelledError:
            raise BusyError(SHUTTING_DOWN) from None

    def close(self) -> None:
        """Drops waiting jobs and tells the running one to end."""
        with self._lock:
            self._closing.set()
        self._pool.shutdown(wait=False, cancel_futures=True)

    def join(self) -> None:
        """Waits for the running job, after ``close``."""
        self._pool.shutdown(wait=True)


def wait_until(condition: Callable[[], bool], timeout_sec: float) -> bool:
    """Waits for a condition that other threads or processes bring about; False when it is late."""
    pause = threading.Event()
    end_sec = time.monotonic() + timeout_sec
    while not condition():
        if time.monotonic() >= end_sec:
            return False
        pause.wait(POLL_SEC)
    return True
