"""What a node says of its own process."""

from __future__ import annotations

import threading
import time

import pytest

from spatial_relations_ros.ros.diagnostics import ProcessorShare

pytestmark = pytest.mark.ros


def work(cpu_sec: float) -> None:
    """Keeps the processor busy on one thread."""
    end_sec = time.thread_time() + cpu_sec
    while time.thread_time() < end_sec:
        pass


def test_the_share_of_a_core_is_that_since_the_last_time_of_all_threads() -> None:
    share = ProcessorShare()
    for num_threads in (1, 2):
        share.percent()
        wall_sec, cpu_sec = time.monotonic(), time.process_time()
        threads = [threading.Thread(target=work, args=(0.1,)) for _ in range(num_threads)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        wall_sec, cpu_sec = time.monotonic() - wall_sec, time.process_time() - cpu_sec
        assert cpu_sec >= 0.1 * num_threads
        assert share.percent() == pytest.approx(100.0 * cpu_sec / wall_sec, rel=0.05)
