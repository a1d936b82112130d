"""Runs one stream after the other through a perception node and measures."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from spatial_relations_ros.core import SpatialRelationsError
from spatial_relations_ros.evaluation.live_rates import LiveRun
from spatial_relations_ros.evaluation.live_stream import (
    CAMERA_FRAME,
    PAIRS,
    RenderedStream,
    StreamFormat,
    render_stream,
)
from spatial_relations_ros.nodes.live_bench.listener import (
    NODE,
    LiveListener,
    processor_seconds,
    resident_megabytes_of,
)
from spatial_relations_ros.nodes.live_bench.publisher import (
    POINTS_TOPIC,
    TRACKS_TOPIC,
    save_stream,
)
from spatial_relations_ros.ros.processes import NodeProcesses, local_graph
from spatial_relations_ros.ros.running import spun
from spatial_relations_ros.ros.waiting import wait_until

WARM_UP_SEC = 2.0
WARM_UPS = 4
START_SEC = 150.0
NUM_MEMORY_SAMPLES = 200
MAX_SAMPLE_PERIOD_SEC = 2.0
DRAIN_SEC = 5.0


class LiveBenchError(SpatialRelationsError):
    """A part of the benchmark that did not start or answer."""


@dataclass(frozen=True)
class LiveOptions:
    """What is measured.

    Attributes:
        duration_sec: of each stream.
        rate: clouds a second.
        is_reliable: whether clouds are sent and asked for reliably.
        with_models: whether the node has the objects' models; else it takes them from the cloud.
        all_pairs: whether scenes of all ordered pairs are published instead of the two of the
            demonstration.
    """

    duration_sec: float = 20.0
    rate: float = 30.0
    is_reliable: bool = False
    with_models: bool = True
    all_pairs: bool = False


def measure(layout: StreamFormat, options: LiveOptions, domain_id: int, folder: Path) -> LiveRun:
    """Measures one stream.

    Args:
        layout: of the clouds.
        options: how long and how.
        domain_id: ROS_DOMAIN_ID of the graph.
        folder: for models, clouds and logs.

    Raises:
        LiveBenchError: when a process does not do its part.
    """
    models = folder / 'models'
    models.mkdir(parents=True)
    stream = render_stream(layout, models)
    save_stream(folder / 'stream.npz', stream)
    environment = local_graph(domain_id, folder / 'log')
    with NodeProcesses(environment, folder / 'log') as processes:
        node = processes.start(
            NODE,
            parameters=_node_parameters(stream, models, options),
            remappings={'~/points': POINTS_TOPIC, '~/tracked_objects': TRACKS_TOPIC},
        )
        with (
            spun(LiveListener, domain_id) as listener,
            _publisher(folder, environment, options) as publisher,
        ):
            return _Run(layout, options, listener, publisher, node.pid).run()


def _node_parameters(
    stream: RenderedStream, models: Path, options: LiveOptions
) -> dict[str, object]:
    pose = stream.world_from_camera
    qw, *quat_xyz = pose.quat_wxyz.tolist()
    numbers = [*pose.translation.tolist(), *quat_xyz, qw]
    return {
        'models_path': str(models) if options.with_models else '',
        'camera_pose': ' '.join(map(str, numbers)),
        'camera_frame': CAMERA_FRAME,
        'pairs': [] if options.all_pairs else ['/'.join(pair) for pair in PAIRS],
        'publish_rate': 100.0,
        'reliable_points': options.is_reliable,
    }


class _Run:
    """The measurement, once all processes are there."""

    def __init__(
        self,
        layout: StreamFormat,
        options: LiveOptions,
        listener: LiveListener,
        publisher: subprocess.Popen[str],
        node_id: int,
    ) -> None:
        self._layout, self._options = layout, options
        self._listener, self._publisher, self._node_id = listener, publisher, node_id
        self._memory: list[tuple[float, float]] = []
        self._num_pairs = 12 if options.all_pairs else len(PAIRS)

    def _warm_up(self) -> None:
        """Sends clouds until scenes come; a busy machine needs more than one attempt."""
        for _ in range(WARM_UPS):
            self._send(round(WARM_UP_SEC * self._options.rate))
            if wait_until(lambda: self._listener.num_scenes > 0, DRAIN_SEC):
                return
        raise LiveBenchError('the perception node gave no scene while it was warmed up')

    def run(self) -> LiveRun:
        options = self._options
        self._warm_up()
        if not self._listener.reset_node():
            raise LiveBenchError('the perception node does not answer')
        cpu_before = processor_seconds(self._node_id)
        stop = threading.Event()
        sampler = threading.Thread(target=self._sample_memory, args=(stop,))
        sampler.start()
        try:
            sent = self._send(round(options.duration_sec * options.rate))
        finally:
            stop.set()
            sampler.join()
        cpu_sec = processor_seconds(self._node_id) - cpu_before
        num_sent = len(sent['stamps'])
        wait_until(lambda: self._listener.num_complete(self._num_pairs) >= num_sent, DRAIN_SEC)
        if not self._listener.next_report():
            raise LiveBenchError('the perception node publishes no diagnostics')
        return self._result(sent, cpu_sec)

    def _result(self, sent: dict[str, Any], cpu_sec: float) -> LiveRun:
        clouds = self._listener.report('clouds')
        topics = self._listener.report('~/points')
        return LiveRun(
            stream=self._layout.name,
            rate=self._options.rate,
            megabytes_per_second=1e-6 * self._layout.num_bytes * self._options.rate,
            duration_sec=float(sent['duration_sec']),
            num_sent=len(sent['stamps']),
            num_received=int(topics.get('received', 0)),
            num_handled=int(clouds.get('handled', 0)),
            num_scenes_of=self._listener.num_complete(self._num_pairs),
            latency_ms=(
                float(clouds.get('latency_median_ms', 'nan')),
                float(clouds.get('latency_p99_ms', 'nan')),
                float(clouds.get('latency_max_ms', 'nan')),
            ),
            ages_ms=self._listener.ages_ms(),
            cpu_sec=cpu_sec,
            memory_mb=tuple(self._memory),
            max_late_ms=float(sent['max_late_ms']),
        )

    def _send(self, count: int) -> dict[str, Any]:
        """Has clouds sent and waits until they are; the publisher first waits for the node."""
        assert self._publisher.stdin is not None
        assert self._publisher.stdout is not None
        self._publisher.stdin.write(f'send {count}\n')
        self._publisher.stdin.flush()
        line = self._publisher.stdout.readline()
        if not line:
            raise LiveBenchError(
                f'the publisher ended with code {self._publisher.wait()} before it had sent all'
            )
        answer: dict[str, Any] = json.loads(line)
        return answer

    def _sample_memory(self, stop: threading.Event) -> None:
        period_sec = min(self._options.duration_sec / NUM_MEMORY_SAMPLES, MAX_SAMPLE_PERIOD_SEC)
        begin_sec = time.monotonic()
        while True:
            with suppress(OSError):  # the node has ended; that is said elsewhere
                megabytes = resident_megabytes_of(self._node_id)
                self._memory.append((time.monotonic() - begin_sec, megabytes))
            if stop.wait(period_sec):
                return


@contextmanager
def _publisher(
    folder: Path, environment: dict[str, str], options: LiveOptions
) -> Iterator[subprocess.Popen[str]]:
    command = [
        sys.executable, '-m', 'spatial_relations_ros.nodes.live_bench.publisher',
        str(folder / 'stream.npz'), '--rate', str(options.rate),
    ]  # fmt: skip
    if options.is_reliable:
        command.append('--reliable')
    with subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, **environment},
    ) as process:
        try:
            yield process
        finally:
            with suppress(OSError):
                process.stdin.close()  # type: ignore[union-attr]
            try:
                process.wait(DRAIN_SEC)
            except subprocess.TimeoutExpired:
                process.kill()
