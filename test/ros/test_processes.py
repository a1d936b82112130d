"""Node processes are found, watched and ended; domains are free."""

from __future__ import annotations

import socket
import time
from pathlib import Path
from xml.etree import ElementTree

import pytest

from spatial_relations_ros.ros.domains import (
    HIGHEST_DOMAIN_ID,
    PORT_BASE,
    PORTS_PER_DOMAIN,
    free_domain_id,
    used_udp_ports,
)
from spatial_relations_ros.ros.processes import (
    NodeProcessError,
    NodeProcesses,
    find_executable,
    local_graph,
)


def test_the_installed_nodes_are_found() -> None:
    assert find_executable('imitate_node').name == 'imitate_node'
    with pytest.raises(NodeProcessError, match='no_such_node is not installed; searched'):
        find_executable('no_such_node')


def test_a_node_that_ends_is_reported_with_its_words(tmp_path: Path) -> None:
    with NodeProcesses(local_graph(free_domain_id(), tmp_path), tmp_path) as processes:
        process = processes.start('perception_node', parameters={'max_age': -1.0})
        assert process.wait(60.0) == 2
        with pytest.raises(NodeProcessError, match=r'ended with code 2:(.|\n)*max_age'):
            processes.check()


def test_a_used_domain_is_not_chosen() -> None:
    first = free_domain_id()
    assert 1 <= first <= HIGHEST_DOMAIN_ID
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(('127.0.0.1', PORT_BASE + PORTS_PER_DOMAIN * first))
        assert PORT_BASE + PORTS_PER_DOMAIN * first in used_udp_ports()
        assert free_domain_id() != first


def environment_of(pid: int) -> list[str]:
    """Variables of a process; there are none for a moment after it was started."""
    deadline = time.monotonic() + 30.0
    while not (given := Path(f'/proc/{pid}/environ').read_text()):
        assert time.monotonic() < deadline
    return given.split('\0')


def test_nodes_fill_no_more_memory_with_messages_than_they_need(tmp_path: Path) -> None:
    environment = local_graph(free_domain_id(), tmp_path)
    with NodeProcesses(environment, tmp_path) as processes:
        node = processes.start('metric_node')
        given = environment_of(node.pid)
    (profile,) = (item.partition('=')[2] for item in given if item.startswith('FASTRTPS'))
    sizes = {}
    for path in (profile, environment['FASTRTPS_DEFAULT_PROFILES_FILE']):
        root = ElementTree.parse(path).getroot()
        sizes[path] = int(root.findtext('.//{*}segment_size'))
        assert sizes[path] >= int(root.findtext('.//{*}maxMessageSize')) >= 1920 * 1080 * 16
    assert min(sizes, key=sizes.__getitem__) == profile
