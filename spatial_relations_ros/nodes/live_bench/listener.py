"""The side of the live benchmark that measures: scenes, diagnostics, the node's process."""

from __future__ import annotations

import os
import threading
from collections import defaultdict
from pathlib import Path

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from spatial_relations_msgs.msg import Scene as SceneMsg
from std_srvs.srv import Trigger

from spatial_relations_ros.perception.messages import stamp_ns
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.waiting import wait_for, wait_until

NODE = 'perception_node'
WAIT_SEC = 120.0
# Diagnostics come once a second.
REPORT_SEC = 10.0


class LiveListener(Node):
    """Receives the scenes of a perception node; spun by a thread of its own."""

    def __init__(self) -> None:
        super().__init__('live_bench_listener')
        self._lock = threading.Lock()
        self._ages_ms: list[float] = []
        self._scenes_of: dict[int, int] = defaultdict(int)
        self._reports: dict[str, dict[str, str]] = {}
        self.num_reports = 0
        self.create_subscription(SceneMsg, f'{NODE}/scenes', self._on_scene, qos.SCENES)
        self.create_subscription(
            DiagnosticArray, '/diagnostics', self._on_diagnostics, qos.DIAGNOSTICS
        )
        self._reset = self.create_client(Trigger, f'{NODE}/reset')

    def _on_scene(self, msg: SceneMsg) -> None:
        cloud_ns = stamp_ns(msg.header.stamp)
        age_ms = 1e-6 * (self.get_clock().now().nanoseconds - cloud_ns)
        with self._lock:
            self._ages_ms.append(age_ms)
            self._scenes_of[cloud_ns] += 1

    def _on_diagnostics(self, msg: DiagnosticArray) -> None:
        with self._lock:
            for status in msg.status:
                self._reports[status.name] = {item.key: item.value for item in status.values}
            self.num_reports += 1

    def report(self, part: str) -> dict[str, str]:
        """What the node said last about one of its parts."""
        with self._lock:
            return dict(self._reports.get(f'{NODE}: {part}', {}))

    def next_report(self) -> bool:
        """Waits for a report that was begun after this call; False when none comes."""
        now = self.num_reports
        return wait_until(lambda: self.num_reports >= now + 2, REPORT_SEC)

    def reset_node(self) -> bool:
        """Makes the node and this listener count from zero; False when it does not answer."""
        if not self._reset.wait_for_service(WAIT_SEC):
            return False
        answer = wait_for(self._reset.call_async(Trigger.Request()), WAIT_SEC)
        with self._lock:
            self._ages_ms.clear()
            self._scenes_of.clear()
        return bool(answer.success)

    @property
    def num_scenes(self) -> int:
        """Since the reset."""
        return len(self._ages_ms)

    def ages_ms(self) -> tuple[float, ...]:
        """Of all scenes since the reset."""
        with self._lock:
            return tuple(self._ages_ms)

    def num_complete(self, num_pairs: int) -> int:
        """How many clouds a scene of each pair has come of since the reset."""
        with self._lock:
            return sum(count >= num_pairs for count in self._scenes_of.values())


def processor_seconds(process_id: int) -> float:
    """Processor time that a process has used, all its threads together."""
    fields = (
        Path(f'/proc/{process_id}/stat').read_text(encoding='ascii').rpartition(')')[2].split()
    )
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def resident_megabytes_of(process_id: int) -> float:
    """Memory that a process holds, MB."""
    pages = int(Path(f'/proc/{process_id}/statm').read_text(encoding='ascii').split()[1])
    return pages * os.sysconf('SC_PAGE_SIZE') / 1e6
