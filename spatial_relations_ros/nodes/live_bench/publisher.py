"""Publishes rendered clouds and tracked poses at a rate: a process of the live benchmark.

It is told what to send on standard input, a line ``send COUNT`` each, and answers on standard
output with one line of JSON; without more lines it ends.
"""

from __future__ import annotations

import argparse
import array
import json
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2, PointField
from spatial_relations_msgs.msg import TrackedObject, TrackedObjectArray
from std_msgs.msg import Header

from spatial_relations_ros.core import Pose
from spatial_relations_ros.evaluation.live_stream import (
    CAMERA_FRAME,
    RenderedStream,
    rgb_offset,
    stream_format,
)
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.conversions import pose_to_msg, stamp_to_msg
from spatial_relations_ros.ros.waiting import wait_until

POINTS_TOPIC, TRACKS_TOPIC = 'points', 'tracked_objects'
DISCOVERY_SEC = 120.0


def save_stream(path: Path, stream: RenderedStream) -> None:
    """Writes what this process reads."""
    content: dict[str, Any] = {'clouds': stream.clouds, 'layout': stream.layout.name}
    content |= {f'pose/{key}': pose.as_matrix() for key, pose in stream.poses.items()}
    np.savez(path, **content)


class StreamPublisher(Node):
    """Publishes one stream."""

    def __init__(self, path: Path, rate: float, *, is_reliable: bool) -> None:
        super().__init__('live_bench_publisher')
        self._period_sec = 1.0 / rate
        with np.load(path) as content:
            layout = stream_format(str(content['layout']))
            self._clouds = [_message(data, layout.point_step) for data in content['clouds']]
            self._poses = {
                key.removeprefix('pose/'): pose_to_msg(Pose.from_matrix(content[key]))
                for key in content.files
                if key.startswith('pose/')
            }
        self._points = self.create_publisher(
            PointCloud2, POINTS_TOPIC, qos.latest_cloud(is_reliable=is_reliable)
        )
        self._tracks = self.create_publisher(TrackedObjectArray, TRACKS_TOPIC, qos.TRACKED_POSES)

    def wait_for_subscribers(self) -> bool:
        """Waits until somebody listens to both topics."""
        topics = (self._points, self._tracks)
        return wait_until(
            lambda: all(topic.get_subscription_count() for topic in topics), DISCOVERY_SEC
        )

    def send(self, count: int) -> dict[str, Any]:
        """Publishes so many clouds, each with its tracked poses just before it.

        Returns:
            The stamps in nanoseconds, and by how much a cloud was late at most.
        """
        stamps: list[int] = []
        max_late_sec = 0.0
        pause = threading.Event()
        begin_sec = time.monotonic()
        for idx in range(count):
            due_sec = begin_sec + idx * self._period_sec
            pause.wait(max(0.0, due_sec - time.monotonic()))
            max_late_sec = max(max_late_sec, time.monotonic() - due_sec)
            stamps.append(self._send_one(idx))
        duration_sec = time.monotonic() - begin_sec
        return {
            'stamps': stamps,
            'max_late_ms': 1e3 * max_late_sec,
            'duration_sec': max(duration_sec, count * self._period_sec),
        }

    def _send_one(self, idx: int) -> int:
        stamp_ns = self.get_clock().now().nanoseconds
        header = Header(stamp=stamp_to_msg(stamp_ns), frame_id=CAMERA_FRAME)
        objects = [
            TrackedObject(header=header, object_id=object_id, pose=pose, confidence=1.0)
            for object_id, pose in self._poses.items()
        ]
        self._tracks.publish(TrackedObjectArray(header=header, objects=objects))
        cloud = self._clouds[idx % len(self._clouds)]
        cloud.header = header
        self._points.publish(cloud)
        return stamp_ns


def _message(data: Any, point_step: int) -> PointCloud2:
    """A message of (H, W * point_step) bytes."""
    height, row_step = data.shape
    offsets = {'x': 0, 'y': 4, 'z': 8, 'rgb': rgb_offset(point_step)}
    return PointCloud2(
        height=height,
        width=row_step // point_step,
        fields=[
            PointField(name=name, offset=offset, datatype=PointField.FLOAT32, count=1)
            for name, offset in offsets.items()
        ],
        is_bigendian=False,
        point_step=point_step,
        row_step=row_step,
        data=array.array('B', data.tobytes()),
        is_dense=False,
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Serves the lines of standard input; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('stream', type=Path, help='as save_stream writes it')
    parser.add_argument('--rate', type=float, required=True, help='clouds a second')
    parser.add_argument('--reliable', action='store_true')
    args = parser.parse_args(arguments)
    rclpy.init(args=[])
    node = StreamPublisher(args.stream, args.rate, is_reliable=args.reliable)
    try:
        if not node.wait_for_subscribers():
            print(f'nobody subscribes within {DISCOVERY_SEC:g} s', file=sys.stderr)
            return 1
        for line in sys.stdin:
            print(json.dumps(node.send(int(line.split()[1]))), flush=True)
    except KeyboardInterrupt:
        return 130
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    return 0


if __name__ == '__main__':
    sys.exit(main())
