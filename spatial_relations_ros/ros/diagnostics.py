"""What a node reports about itself on /diagnostics, once a second."""

from __future__ import annotations

import os
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from spatial_relations_ros.ros.qos import DIAGNOSTICS
from spatial_relations_ros.ros.timers import steady_timer

PERIOD_SEC = 1.0
RATE_WINDOW_SEC = 5.0
RECENT_SEC = 10.0
LOG_PERIOD_SEC = 5.0

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


@dataclass(frozen=True)
class State:
    """The state of one part of a node: a level of DiagnosticStatus, words, and values."""

    level: bytes
    message: str
    values: Mapping[str, object] = field(default_factory=dict)


@dataclass
class _Traffic:
    """What came in on one topic or service."""

    num_received: int = 0
    num_bad: int = 0
    last_reason: str = ''
    last_bad_sec: float = -1e9
    last_logged_sec: float = -1e9
    arrivals_sec: deque[float] = field(default_factory=lambda: deque(maxlen=300))

    def state(self, now_sec: float) -> State:
        recent = [arrival for arrival in self.arrivals_sec if now_sec - arrival < RATE_WINDOW_SEC]
        values: dict[str, object] = {
            'received': self.num_received,
            'bad': self.num_bad,
            'rate_hz': f'{len(recent) / RATE_WINDOW_SEC:.1f}',
        }
        if self.arrivals_sec:
            values['age_sec'] = f'{now_sec - self.arrivals_sec[-1]:.1f}'
        if self.num_bad:
            values['last_bad_reason'] = self.last_reason
        if now_sec - self.last_bad_sec < RECENT_SEC:
            return State(WARN, f'bad message: {self.last_reason}', values)
        return State(OK, 'receiving' if recent else 'idle', values)


def resident_megabytes() -> float:
    """Memory that this process holds, in MB."""
    with open('/proc/self/statm', encoding='ascii') as file:
        pages = int(file.read().split()[1])
    return pages * os.sysconf('SC_PAGE_SIZE') / 1e6


class ProcessorShare:
    """How much of one core this process takes, all its threads together."""

    def __init__(self) -> None:
        self._wall_sec, self._cpu_sec = time.monotonic(), time.process_time()

    def percent(self) -> float:
        """Since the last call, or since the start; 100 is one core."""
        wall_sec, cpu_sec = time.monotonic(), time.process_time()
        used_sec, passed_sec = cpu_sec - self._cpu_sec, wall_sec - self._wall_sec
        self._wall_sec, self._cpu_sec = wall_sec, cpu_sec
        return 100.0 * used_sec / max(passed_sec, 1e-6)


class Diagnostics:
    """Counts what arrives at a node and publishes it with the states of the node's parts."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._lock = threading.Lock()
        self._traffic: dict[str, _Traffic] = {}
        self._states: dict[str, Callable[[], State]] = {'process': self._process_state}
        self._share = ProcessorShare()
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', DIAGNOSTICS)
        self._timer = steady_timer(node, PERIOD_SEC, self.publish)

    def add_state(self, name: str, state: Callable[[], State]) -> None:
        """Adds a part of the node; ``state`` is asked once a second."""
        self._states[name] = state

    def expect(self, topic: str) -> None:
        """Lists a topic from the start, before anything has arrived on it."""
        with self._lock:
            self._traffic.setdefault(topic, _Traffic())

    def clear(self) -> None:
        """Counts from zero again."""
        with self._lock:
            self._traffic = {topic: _Traffic() for topic in self._traffic}

    def count(self, topic: str) -> None:
        """Counts a message or request."""
        with self._lock:
            traffic = self._traffic.setdefault(topic, _Traffic())
            traffic.num_received += 1
            traffic.arrivals_sec.append(time.monotonic())

    def count_bad(self, topic: str, reason: str) -> bool:
        """Counts one that could not be used; True when it is time to log it again."""
        now_sec = time.monotonic()
        with self._lock:
            traffic = self._traffic.setdefault(topic, _Traffic())
            is_new = reason != traffic.last_reason
            traffic.num_bad += 1
            traffic.last_reason = reason
            traffic.last_bad_sec = now_sec
            is_due = now_sec - traffic.last_logged_sec > (1.0 if is_new else LOG_PERIOD_SEC)
            if is_due:
                traffic.last_logged_sec = now_sec
        return is_due

    def publish(self) -> None:
        """Publishes everything now; the timer calls it."""
        now_sec = time.monotonic()
        with self._lock:
            states = {topic: traffic.state(now_sec) for topic, traffic in self._traffic.items()}
        for name, ask in self._states.items():
            try:
                states[name] = ask()
            except Exception as error:  # a report must not end the node
                states[name] = State(ERROR, f'{type(error).__name__}: {error}')
        name = self._node.get_fully_qualified_name().lstrip('/')
        message = DiagnosticArray()
        message.header.stamp = self._node.get_clock().now().to_msg()
        message.status = [
            DiagnosticStatus(
                level=state.level,
                name=f'{name}: {part}',
                message=state.message,
                hardware_id='none',
                values=[KeyValue(key=k, value=str(v)) for k, v in state.values.items()],
            )
            for part, state in states.items()
        ]
        self._publisher.publish(message)

    def _process_state(self) -> State:
        values = {
            'memory_mb': f'{resident_megabytes():.0f}',
            'cpu_percent': f'{self._share.percent():.0f}',
            'threads': threading.active_count(),
        }
        return State(OK, 'running', values)
