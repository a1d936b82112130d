"""The metric node's file of relations, used by several requests at once."""

from __future__ import annotations

import sqlite3
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
from numpy.typing import NDArray
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.task import Future
from spatial_relations_msgs.srv import Embed, ListRelations, Nearest, Remember
from std_srvs.srv import Trigger

from spatial_relations_ros.core import MemoryFileError, Pose, Scene, SceneObject
from spatial_relations_ros.memory import RelationMemory
from spatial_relations_ros.nodes.metric_node import MetricNode
from spatial_relations_ros.nodes.model_host import ModelHost
from spatial_relations_ros.ros.conversions import scene_to_msg
from spatial_relations_ros.ros.domains import free_domain_id
from spatial_relations_ros.ros.running import NUM_THREADS, SpinThread, WaitingExecutor
from spatial_relations_ros.ros.waiting import Worker, wait_for, wait_until

pytestmark = pytest.mark.ros

LIMIT_SEC = 30.0
BATCH = 64
NUM_RELATIONS = BATCH + 6


def make_scene(number: int) -> Scene:
    points = np.full((4, 3), number, dtype=np.float32)
    return Scene(SceneObject('a', points, Pose()), SceneObject('b', points, Pose()))


class HeldMetric:
    """Embeds several scenes at once only when the test lets it."""

    model_hash = 'new'

    def __init__(self) -> None:
        self.calls: list[int] = []
        self.is_embedding, self.may_go_on = threading.Event(), threading.Event()

    def novelty(self, embedding: NDArray[np.float32]) -> float:
        return float(embedding[0])

    def embed_scenes(self, scenes: Sequence[Scene]) -> NDArray[np.float32]:
        self.calls.append(len(scenes))
        if len(scenes) > 1:
            self.is_embedding.set()
            assert self.may_go_on.wait(LIMIT_SEC)
        return np.stack([np.full(4, scene.base.points[0, 0]) for scene in scenes])


class HeldHost(ModelHost):
    """Has that metric."""

    def __init__(self) -> None:
        super().__init__(Worker(), lambda: '')
        self.held = HeldMetric()

    def metric(self) -> Any:
        return self.held


class Rig:
    """The node in this process, and a client."""

    def __init__(self, memory_path: Path) -> None:
        self.memory_path = memory_path
        self.context = Context()
        rclpy.init(context=self.context, domain_id=free_domain_id())
        self.host = HeldHost()
        self.metric = self.host.held
        node = MetricNode(
            self.host,
            context=self.context,
            parameter_overrides=[Parameter('memory_path', value=str(memory_path))],
        )
        self.serving = SpinThread(WaitingExecutor(NUM_THREADS, context=self.context), node)
        self._node = Node('client', context=self.context)
        self._asking = SpinThread(SingleThreadedExecutor(context=self.context), self._node)

    def send(self, kind: Any, service: str, **fields: Any) -> Future:
        client = self._node.create_client(kind, f'/metric_node/{service}')
        assert client.wait_for_service(LIMIT_SEC)
        return client.call_async(kind.Request(**fields))

    def call(self, kind: Any, service: str) -> Any:
        return wait_for(self.send(kind, service), LIMIT_SEC)

    def send_nearest(self) -> Future:
        return self.send(Nearest, 'nearest', scene=[scene_to_msg(make_scene(0))], k=100)

    def models(self) -> list[str]:
        with RelationMemory(self.memory_path) as memory:
            return [relation.model_hash for relation in memory.list()]

    def close(self) -> None:
        self.metric.may_go_on.set()
        self.serving.close()
        self._asking.close()
        rclpy.shutdown(context=self.context)


@pytest.fixture
def rig(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Rig]:
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    path = tmp_path / 'relations.sqlite3'
    with RelationMemory(path) as memory:
        for idx in range(NUM_RELATIONS):
            memory.remember(f'{idx:03d}', make_scene(idx), np.zeros(4), 'old')
    rig = Rig(path)
    yield rig
    rig.close()


def test_relations_are_listed_while_new_weights_embed_them(rig: Rig) -> None:
    nearest = rig.send_nearest()
    assert rig.metric.is_embedding.wait(LIMIT_SEC)
    assert len(rig.call(ListRelations, 'list').names) == NUM_RELATIONS
    rig.metric.may_go_on.set()
    assert list(wait_for(nearest, LIMIT_SEC).names) == [f'{idx:03d}' for idx in range(70)]


def test_other_requests_have_their_turn_between_batches(rig: Rig) -> None:
    nearest = rig.send_nearest()
    assert rig.metric.is_embedding.wait(LIMIT_SEC)
    embedded = rig.send(Embed, 'embed', scene=[scene_to_msg(make_scene(0))])
    assert wait_until(lambda: rig.host.worker.num_pending == 2, LIMIT_SEC)
    rig.metric.may_go_on.set()
    assert len(wait_for(nearest, LIMIT_SEC).names) == NUM_RELATIONS
    assert wait_for(embedded, LIMIT_SEC).model_hash == 'new'
    assert rig.metric.calls == [1, BATCH, 1, NUM_RELATIONS - BATCH]


def test_a_damaged_relation_is_in_the_log(rig: Rig, capfd: pytest.CaptureFixture[str]) -> None:
    with sqlite3.connect(rig.memory_path) as raw:
        raw.execute('UPDATE objects SET source = 9 WHERE relation_id = 2')
    raw.close()
    rig.metric.may_go_on.set()
    response = wait_for(rig.send_nearest(), LIMIT_SEC)
    assert response.success, response.message
    assert len(response.names) == NUM_RELATIONS - 1
    assert '[WARN]' in (logged := capfd.readouterr().err)
    assert "'001' is damaged" in logged


def test_it_ends_after_a_batch_and_goes_on_there(rig: Rig) -> None:
    nearest = rig.send_nearest()
    assert rig.metric.is_embedding.wait(LIMIT_SEC)
    ending = threading.Thread(target=rig.serving.close)
    ending.start()
    assert wait_until(lambda: rig.host.worker.is_closing, LIMIT_SEC)
    rig.metric.may_go_on.set()
    response = wait_for(nearest, LIMIT_SEC)
    ending.join(LIMIT_SEC)
    assert not ending.is_alive()
    assert not response.success
    assert 'shutting down' in response.message
    assert rig.metric.calls == [1, BATCH]
    assert rig.models() == ['new'] * BATCH + ['old'] * 6


def test_a_reset_leaves_the_file_to_requests_that_run(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    used: list[RelationMemory] = []
    is_used, may_go_on = threading.Event(), threading.Event()
    list_relations = RelationMemory.list

    def list_late(memory: RelationMemory) -> Any:
        used.append(memory)
        is_used.set()
        assert may_go_on.wait(LIMIT_SEC)
        return list_relations(memory)

    monkeypatch.setattr(RelationMemory, 'list', list_late)
    listing = rig.send(ListRelations, 'list')
    assert is_used.wait(LIMIT_SEC)
    assert rig.call(Trigger, 'reset').success
    rig.host.worker.run(lambda: None)  # after whatever the reset left to the worker
    may_go_on.set()
    response = wait_for(listing, LIMIT_SEC)
    assert response.success, response.message
    assert rig.call(ListRelations, 'list').success
    first, second = used
    assert first is not second
    with pytest.raises(MemoryFileError, match='closed'):
        list_relations(first)


def test_a_locked_file_holds_only_what_writes_into_it(rig: Rig) -> None:
    scene = [scene_to_msg(make_scene(0))]
    blocker = sqlite3.connect(rig.memory_path, isolation_level=None)
    blocker.execute('BEGIN IMMEDIATE')
    try:
        remembered = rig.send(Remember, 'remember', name='new', scene=scene)
        assert wait_until(lambda: rig.metric.calls == [1], LIMIT_SEC)
        assert wait_for(rig.send(Embed, 'embed', scene=scene), LIMIT_SEC).success
        assert not remembered.done()
    finally:
        blocker.execute('ROLLBACK')
        blocker.close()
    response = wait_for(remembered, LIMIT_SEC)
    assert response.success, response.message


def test_a_file_that_is_put_in_its_place_is_used(
    rig: Rig, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert len(rig.call(ListRelations, 'list').names) == NUM_RELATIONS
    copy = tmp_path / 'copy.sqlite3'
    with RelationMemory(copy) as memory:
        memory.remember('restored', make_scene(0), np.zeros(4), 'new')
    copy.replace(rig.memory_path)
    scene = [scene_to_msg(make_scene(0))]
    response = wait_for(rig.send(Remember, 'remember', name='new', scene=scene), LIMIT_SEC)
    assert response.success, response.message
    assert list(rig.call(ListRelations, 'list').names) == ['new', 'restored']
    assert len(rig.models()) == 2
    assert 'was moved, removed or replaced; it is opened anew' in capfd.readouterr().err
    rig.memory_path.unlink()
    assert not rig.call(ListRelations, 'list').names
