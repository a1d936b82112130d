"""The thread of perception: it waits for poses, and messages never wait for it."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator

import numpy as np
import pytest

from spatial_relations_ros.core import Pose
from spatial_relations_ros.nodes.frame_worker import FrameWorker
from spatial_relations_ros.perception.assembler import OVERRUN, FrameAssembler
from spatial_relations_ros.perception.border import Frame, TrackedPose
from spatial_relations_ros.perception.point_cloud2 import PointCloud

CLOUD = PointCloud(np.zeros((2, 2, 3), dtype=np.float32))
MS = 1_000_000
LIMIT_SEC = 30.0


class Rig:
    """A worker whose clock and step the test holds."""

    def __init__(self) -> None:
        self.now_ns = 0
        self.frames: queue.Queue[Frame] = queue.Queue()
        self.may_go_on = threading.Event()
        self.may_go_on.set()
        self.worker = FrameWorker(FrameAssembler(), self._handle, lambda: self.now_ns)

    def _handle(self, frame: Frame) -> None:
        self.frames.put(frame)
        self.may_go_on.wait(LIMIT_SEC)

    def track(self, *stamps_ms: int) -> None:
        with self.worker.assembler() as assembler:
            assembler.add_tracks(
                TrackedPose('cup', stamp * MS, 'camera', Pose()) for stamp in stamps_ms
            )

    def cloud(self, *stamps_ms: int) -> None:
        with self.worker.assembler() as assembler:
            for stamp in stamps_ms:
                assembler.add_cloud(stamp * MS, 'camera', CLOUD, self.now_ns)

    def next(self) -> tuple[int, list[int]]:
        frame = self.frames.get(timeout=LIMIT_SEC)
        return frame.stamp_ns // MS, [track.stamp_ns // MS for track in frame.tracks]


@pytest.fixture
def rig() -> Iterator[Rig]:
    rig = Rig()
    yield rig
    rig.may_go_on.set()
    rig.worker.close()


def test_a_cloud_is_handled_when_its_pose_comes(rig: Rig) -> None:
    rig.track(100)
    rig.cloud(100)
    assert rig.next() == (100, [100])
    rig.cloud(133)
    rig.track(130)
    rig.track(140)
    assert rig.next() == (133, [130, 140])


def test_a_cloud_whose_pose_never_comes_is_handled_when_the_clock_says_so(rig: Rig) -> None:
    rig.track(100)
    rig.cloud(133)
    rig.now_ns = 99 * MS
    with pytest.raises(queue.Empty):
        rig.frames.get(timeout=0.05)
    rig.now_ns = 100 * MS
    assert rig.next() == (133, [100])


def test_messages_are_taken_in_while_a_frame_is_handled(rig: Rig) -> None:
    rig.may_go_on.clear()
    rig.track(100)
    rig.cloud(100)
    assert rig.next() == (100, [100])
    for stamp in range(110, 300, 10):  # blocks for ever if it waits for the step
        rig.track(stamp)
    rig.cloud(*range(130, 190, 10))  # one more than are kept
    rig.may_go_on.set()
    assert rig.next() == (180, list(range(110, 190, 10)))
    with rig.worker.assembler() as assembler:
        assert assembler.dropped == {OVERRUN: 5}


def test_it_ends_while_a_cloud_waits() -> None:
    rig = Rig()
    rig.track(100)
    rig.cloud(133)
    rig.worker.close()
    assert rig.frames.empty()
