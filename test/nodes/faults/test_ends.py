"""Nodes that are killed, a disk that is full, and two nodes of one name."""

from __future__ import annotations

import errno
import os
import signal
import sqlite3
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from ros_graph import Graph
from spatial_relations_msgs.srv import Imitate, ListRelations, Remember

from spatial_relations_ros.ros import qos

from .conftest import Faults
from .three_nodes import PAIR, ThreeNodes

pytestmark = pytest.mark.ros

DISK_BYTES = 20_000_000


@pytest.fixture(scope='module')
def disk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder on a disk of its own of 20 MB; an ordinary one where none can be mounted."""
    folder = tmp_path_factory.mktemp('disk')
    mount = ['mount', '-t', 'tmpfs', '-o', f'size={DISK_BYTES}', 'tmpfs', str(folder)]
    try:
        is_mounted = subprocess.run(mount, capture_output=True, check=False).returncode == 0
    except FileNotFoundError:
        is_mounted = False
    yield folder
    if is_mounted:
        subprocess.run(['umount', '--lazy', str(folder)], check=True)


@pytest.fixture(scope='module')
def nodes(
    graph: Graph, disk: Path, weights: Path, tmp_path_factory: pytest.TempPathFactory
) -> ThreeNodes:
    folder = tmp_path_factory.mktemp('ends')
    return ThreeNodes(graph, folder / 'models', weights, disk / 'memory.sqlite3')


def fill(path: Path) -> None:
    with open(path, 'wb', buffering=0) as file:
        while True:
            file.write(bytes(65536))


def remember(nodes: ThreeNodes, name: str) -> Remember.Response:
    return nodes.graph.call_until_answered(
        Remember, '/metric_node/remember', name=name, object_ids=PAIR
    )


def names(nodes: ThreeNodes) -> list[str]:
    return list(nodes.graph.call_until_answered(ListRelations, '/metric_node/list').names)


def burst(nodes: ThreeNodes, kind: Any, service: str, **fields: Any) -> list[Any]:
    """Sends six requests at once; their answers come into the list."""
    answers: list[Any] = []
    client = nodes.graph.node.create_client(kind, service, qos_profile=qos.REQUESTS)
    nodes.graph.wait(client.service_is_ready, service)
    for _ in range(6):
        future = client.call_async(kind.Request(**fields))
        future.add_done_callback(lambda done: answers.append(done.result()))
    return answers


def test_a_full_disk_refuses_and_loses_nothing(
    nodes: ThreeNodes, disk: Path, faults: Faults
) -> None:
    if not disk.is_mount():
        pytest.skip('no small disk can be mounted here')
    assert remember(nodes, 'before').success
    filler = disk / 'filler'
    with faults('disk of the memory file is full') as row:
        with pytest.raises(OSError, match=os.strerror(errno.ENOSPC)):
            fill(filler)
        refused = remember(nodes, 'while full')
        assert not refused.success
        assert 'the disk is full; nothing was changed' in refused.message
        row.said = 'the disk is full; nothing was changed'
        assert names(nodes) == ['before']
        filler.unlink()
        row.is_over()
        assert remember(nodes, 'after').success
        row.is_back()
    assert names(nodes) == ['after', 'before']


def test_a_killed_metric_node_leaves_a_whole_memory(
    nodes: ThreeNodes, disk: Path, faults: Faults
) -> None:
    assert remember(nodes, 'kept').success
    with faults('metric_node is killed while it remembers') as row:
        stored = burst(
            nodes, Remember, '/metric_node/remember', name='new', replace=True, object_ids=PAIR
        )
        # After one of them, while others are being written.
        nodes.graph.wait(lambda: bool(stored), 'an answer')
        assert nodes.graph.processes.end('metric_node', signal.SIGKILL) == -signal.SIGKILL
        with sqlite3.connect(disk / 'memory.sqlite3') as database:
            assert database.execute('PRAGMA integrity_check').fetchone() == ('ok',)
        nodes.start_metric()
        row.is_over()
        nodes.graph.wait(lambda: 'kept' in names(nodes), 'the memory of before')
        assert remember(nodes, 'again').success
        row.is_back('its start included')
        row.said = f'file whole, {len(names(nodes))} relations'


def can_imitate(nodes: ThreeNodes) -> Callable[[], bool]:
    return lambda: bool(nodes.imitate().answers)


def test_without_perception_imitate_says_so_and_recovers(
    nodes: ThreeNodes, faults: Faults
) -> None:
    with faults('perception_node is killed') as row:
        nodes.graph.processes.end('perception_node', signal.SIGKILL)
        refused = nodes.imitate()
        assert not refused.success
        assert 'perception_node/get_scene: no answer within 3 s' in refused.message
        row.said = refused.message
        nodes.cell.start()
        row.is_over()
        nodes.cell.wait_well(150.0)
        nodes.graph.wait(can_imitate(nodes), 'an imitation')
        row.is_back('its start included')


def test_a_client_of_a_killed_imitate_node_is_served_by_the_next(
    nodes: ThreeNodes, faults: Faults
) -> None:
    with faults('imitate_node is killed while it imitates') as row:
        answered = burst(nodes, Imitate, '/imitate', reference_ids=PAIR, test_ids=PAIR[::-1])
        nodes.graph.wait(lambda: bool(answered), 'an answer')
        nodes.graph.processes.end('imitate_node', signal.SIGKILL)
        assert 'before' in names(nodes)  # the others do not mind
        nodes.start_imitate()
        row.is_over()
        nodes.graph.wait(can_imitate(nodes), 'an imitation')
        row.is_back('its start included')
        row.said = 'the client that was there before is served by the new node'


def test_two_nodes_of_one_name_are_told(nodes: ThreeNodes, faults: Faults) -> None:
    graph = nodes.graph

    def level() -> str:
        return graph.diagnostic('perception_node: name')['level']

    # Those that were killed above still count for a while.
    graph.wait(lambda: level() == '0', 'a single perception_node')
    with faults('a second node is named perception_node') as row:
        graph.processes.start(
            'perception_node', parameters=nodes.cell.parameters, name='second_perception'
        )
        graph.wait(lambda: level() == '1', 'a warning')
        row.said = graph.diagnostic('perception_node: name')['message']
        assert '2 nodes are named /perception_node' in row.said
        # Either of them may have told first.
        log = graph.processes.log_path('perception_node')
        graph.wait(lambda: '2 nodes are named /perception_node' in log.read_text(), 'a log line')
        assert graph.processes.end('second_perception') == 0
        row.is_over()
        graph.wait(lambda: level() == '0', 'the end of the warning')
        nodes.cell.wait_well()
        row.is_back()
