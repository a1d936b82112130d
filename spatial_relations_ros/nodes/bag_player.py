"""Publishes a bag's messages as they were recorded: their bytes, at their times."""

from __future__ import annotations

import importlib
import struct
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.time import Time
from rosgraph_msgs.msg import Clock

from spatial_relations_ros.core import BagError
from spatial_relations_ros.evaluation.bag_reader import BagReader
from spatial_relations_ros.evaluation.bag_types import POINT_CLOUD
from spatial_relations_ros.perception.series import NS_PER_SEC
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.stop_request import StopRequest
from spatial_relations_ros.ros.waiting import NoAnswerError, wait_until

CDR_HEADER_BYTES = 4
CLOCK_PERIOD_SEC = 0.025
DELIVERY_SEC = 5.0


def message_class(msgtype: str) -> Any:
    """The message class of a name such as ``sensor_msgs/msg/PointCloud2``."""
    package, kind, name = msgtype.split('/')
    return getattr(importlib.import_module(f'{package}.{kind}'), name)


def stamp_of_cdr(data: bytes) -> int:
    """Stamp in nanoseconds of a serialized message that begins with a header."""
    byte_order = '<' if data[1] & 1 else '>'
    sec, nanosec = struct.unpack_from(f'{byte_order}iI', data, CDR_HEADER_BYTES)
    return int(sec) * NS_PER_SEC + int(nanosec)


class BagPlayer:
    """Plays one bag on a node's publishers.

    Args:
        node: publishes; it need not be spun.
        path: the bag.
        rate: how many times faster than recorded.
        has_clock: publish the recorded times on /clock, for nodes with ``use_sim_time``.
        stop: ends what is waited for or played once it is set.

    Attributes:
        contents: topic -> its type and number of messages.
        left_out: topics whose message package is not here -> that type.

    Raises:
        BagError: when the bag is missing, damaged or empty.
    """

    def __init__(
        self, node: Node, path: Path, *, rate: float = 1.0, has_clock: bool = False,
        stop: StopRequest | None = None,
    ) -> None:  # fmt: skip
        self._path, self._rate = path, rate
        self._stop = stop or StopRequest()
        self._clock = node.create_publisher(Clock, '/clock', qos.CLOCK) if has_clock else None
        with BagReader(path) as reader:
            self.contents = reader.contents
            self.duration_sec = reader.duration_ns / 1e9
        self.left_out: dict[str, str] = {}
        self._publishers: dict[str, Publisher] = {}
        for topic, (msgtype, _) in self.contents.items():
            try:
                kind = message_class(msgtype)
            except (ImportError, AttributeError):
                self.left_out[topic] = msgtype
                continue
            self._publishers[topic] = node.create_publisher(kind, topic, _qos_of(topic, msgtype))

    def wait_for_subscribers(self, topics: list[str], timeout_sec: float) -> None:
        """Waits until somebody listens to each of the topics.

        Raises:
            BagError: for a topic that is not published.
            NoAnswerError: when nobody does in time.
        """
        silent = set(topics)
        unknown = sorted(silent - set(self._publishers))
        if unknown:
            raise BagError(
                f'nothing is published on {", ".join(unknown)}; topics of the bag: '
                f'{", ".join(sorted(self._publishers))}'
            )

        def all_heard() -> bool:
            for topic in list(silent):
                if self._publishers[topic].get_subscription_count():
                    silent.discard(topic)
            return not silent or self._stop.is_set()

        if not wait_until(all_heard, timeout_sec):
            raise NoAnswerError(f'nobody subscribes to {", ".join(sorted(silent))}')

    def play(self, after_cloud: Callable[[int], None] | None = None) -> int:
        """Publishes everything once with the timing of ``rate``, or slower where it is late.

        What is late delays all that follows: messages never come in bursts that were none. At the
        end it waits some seconds until all has been delivered, since a publisher that ends takes
        what was not with it.

        Args:
            after_cloud: called with each cloud's stamp in nanoseconds; waiting there keeps
                subscribers from being overrun on a busy machine.

        Returns:
            The number of messages.
        """
        num_published = 0
        with BagReader(self._path) as reader:
            begin_sec = time.monotonic()
            for message in reader.raw():
                if message.topic in self.left_out:
                    continue
                offset_sec = (message.time_ns - reader.start_ns) / 1e9 / self._rate
                if not self._wait_until(begin_sec + offset_sec, message.time_ns):
                    break
                self._publishers[message.topic].publish(message.data)
                num_published += 1
                if after_cloud is not None and message.msgtype == POINT_CLOUD:
                    after_cloud(stamp_of_cdr(message.data))
                begin_sec = max(begin_sec, time.monotonic() - offset_sec)
        self._deliver()
        return num_published

    def _deliver(self) -> None:
        """Waits until subscribers have acknowledged what was published, or it is to stop."""
        end_sec = time.monotonic() + DELIVERY_SEC
        for publisher in self._publishers.values():
            left_sec = max(0.0, end_sec - time.monotonic())
            if not self._stop.is_set():
                publisher.wait_for_all_acked(Duration(seconds=left_sec))

    def _wait_until(self, due_sec: float, time_ns: int) -> bool:
        """Waits for a message's time, with /clock going on; False when it is to stop."""
        while True:
            left_sec = max(0.0, due_sec - time.monotonic())
            if self._clock is not None:
                now_ns = time_ns - round(left_sec * self._rate * NS_PER_SEC)
                self._clock.publish(Clock(clock=Time(nanoseconds=now_ns).to_msg()))
                left_sec = min(left_sec, CLOCK_PERIOD_SEC)
            if self._stop.wait(left_sec):
                return False
            if time.monotonic() >= due_sec:
                return True


def _qos_of(topic: str, msgtype: str) -> QoSProfile:
    if topic == '/tf_static':
        return qos.STATIC_TRANSFORMS
    if msgtype == POINT_CLOUD:
        return qos.latest_cloud(is_reliable=True)
    return qos.TRANSFORMS
