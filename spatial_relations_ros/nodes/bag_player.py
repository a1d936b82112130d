"""Publishes a bag's messages as they were recorded: their bytes, at their times."""

from __future__ import annotations

import importlib
import threading
import time
from pathlib import Path
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

from spatial_relations_ros.evaluation.bag_reader import BagReader
from spatial_relations_ros.evaluation.bag_types import POINT_CLOUD
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.waiting import NoAnswerError, wait_until


def message_class(msgtype: str) -> Any:
    """The message class of a name such as ``sensor_msgs/msg/PointCloud2``."""
    package, kind, name = msgtype.split('/')
    return getattr(importlib.import_module(f'{package}.{kind}'), name)


class BagPlayer:
    """Plays one bag on a node's publishers.

    Args:
        node: publishes; it need not be spun.
        path: the bag.

    Raises:
        BagError: when the bag is missing, damaged or empty.
    """

    def __init__(self, node: Node, path: Path) -> None:
        self._path = path
        self._stop = threading.Event()
        with BagReader(path) as reader:
            self.contents = reader.contents
            self.duration_sec = reader.duration_ns / 1e9
        self._publishers: dict[str, Publisher] = {
            topic: node.create_publisher(message_class(msgtype), topic, _qos_of(topic, msgtype))
            for topic, (msgtype, _) in self.contents.items()
        }

    def wait_for_subscribers(self, topics: list[str], timeout_sec: float) -> None:
        """Waits until somebody listens to each of the topics.

        Raises:
            NoAnswerError: when nobody does in time.
        """
        silent = set(topics)

        def all_heard() -> bool:
            for topic in list(silent):
                if self._publishers[topic].get_subscription_count():
                    silent.discard(topic)
            return not silent

        if not wait_until(all_heard, timeout_sec):
            raise NoAnswerError(f'nobody subscribes to {", ".join(sorted(silent))}')

    def play(self) -> int:
        """Publishes everything once with the recorded timing; returns the number of messages."""
        num_published = 0
        with BagReader(self._path) as reader:
            begin_sec = time.monotonic()
            for message in reader.raw():
                due_sec = begin_sec + (message.time_ns - reader.start_ns) / 1e9
                if self._stop.wait(max(0.0, due_sec - time.monotonic())):
                    break
                self._publishers[message.topic].publish(message.data)
                num_published += 1
        return num_published

    def stop(self) -> None:
        """Ends ``play`` early; callable from another thread."""
        self._stop.set()


def _qos_of(topic: str, msgtype: str) -> QoSProfile:
    if topic == '/tf_static':
        return qos.STATIC_TRANSFORMS
    if msgtype == POINT_CLOUD:
        return qos.latest_cloud(is_reliable=True)
    return qos.TRANSFORMS
