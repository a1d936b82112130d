"""The worker thread and waiting for other threads."""

from __future__ import annotations

import threading
from concurrent.futures import CancelledError

import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.task import Future

from spatial_relations_ros.ros.waiting import (
    BusyError,
    NoAnswerError,
    Worker,
    sent_by,
    wait_for,
    wait_until,
)


def test_jobs_run_on_one_thread_that_is_not_the_callers() -> None:
    worker = Worker()
    threads = {worker.submit(threading.get_ident).result() for _ in range(4)}
    assert len(threads) == 1
    assert threading.get_ident() not in threads
    worker.close()


def test_errors_of_a_job_reach_the_caller() -> None:
    worker = Worker()
    with pytest.raises(ZeroDivisionError):
        worker.run(lambda: 1 // 0)
    assert worker.run(lambda: 'alive') == 'alive'
    worker.close()


def test_a_long_queue_is_refused_instead_of_growing() -> None:
    worker, gate = Worker(max_pending=2), threading.Event()
    jobs = [worker.submit(gate.wait) for _ in range(2)]
    with pytest.raises(BusyError, match='2 requests wait already'):
        worker.submit(gate.wait)
    gate.set()
    assert [job.result(5.0) for job in jobs] == [True, True]
    assert wait_until(lambda: worker.num_pending == 0, 5.0)
    assert worker.run(lambda: 3) == 3
    worker.close()


def test_closing_drops_what_waits_and_tells_what_runs() -> None:
    worker, started = Worker(), threading.Event()

    def long_job() -> str:
        started.set()
        assert wait_until(lambda: worker.is_closing, 5.0)
        return 'ended'

    running, waiting = worker.submit(long_job), worker.submit(lambda: 'never')
    assert started.wait(5.0)
    worker.close()
    assert running.result(5.0) == 'ended'
    with pytest.raises(CancelledError):
        waiting.result(5.0)
    with pytest.raises(BusyError, match='shutting down'):
        worker.submit(lambda: None)


def test_a_future_is_waited_for_but_not_for_ever() -> None:
    future: Future = Future()
    threading.Timer(0.05, lambda: future.set_result('here')).start()
    assert wait_for(future, 5.0) == 'here'
    with pytest.raises(NoAnswerError, match=r'within 0\.01 s'):
        wait_for(Future(), 0.01)


def test_requests_of_an_action_client_leave_on_the_thread_that_hears_the_answers() -> None:
    context = Context()
    rclpy.init(context=context)
    executor = SingleThreadedExecutor(context=context)
    thread = threading.Thread(target=executor.spin)
    thread.start()
    answer, senders = Future(), list[int | None]()

    def send() -> Future:
        senders.append(threading.get_ident())
        return answer

    try:
        assert sent_by(executor, send, 30.0) is answer
        assert senders == [thread.ident]
    finally:
        executor.shutdown()
        thread.join()
        rclpy.shutdown(context=context)
