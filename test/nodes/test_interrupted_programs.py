"""Programs that start nodes end them when they are ended themselves."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import uuid
from collections.abc import Sequence
from pathlib import Path

import pytest

from spatial_relations_ros.ros.waiting import wait_until

pytestmark = pytest.mark.ros

LIMIT_SEC = 120.0
MARK = 'TEST_OF_INTERRUPTS'
INTERRUPTED = 130
LIVE_BENCH = ('spatial_relations_ros.cli.main', 'bench', 'live', '--duration', '600')
DEMO = ('spatial_relations_ros.nodes.demo', '--out', 'out', '--bags')


def commands_marked(mark: str) -> list[str]:
    """Command lines of all running processes that were started with this mark."""
    found = []
    for folder in Path('/proc').glob('[0-9]*'):
        try:
            if f'{MARK}={mark}'.encode() in (folder / 'environ').read_bytes().split(b'\0'):
                found.append((folder / 'cmdline').read_bytes().replace(b'\0', b' ').decode())
        except OSError:  # it has ended, or is another user's
            continue
    return [command for command in found if command]  # of a zombie nothing is left


def has_node(mark: str) -> bool:
    return any('perception_node' in command for command in commands_marked(mark))


@pytest.mark.parametrize(
    ('program', 'number'),
    [(LIVE_BENCH, signal.SIGTERM), (DEMO, signal.SIGINT)],
    ids=['live_bench', 'demo'],
)
def test_no_node_is_left(
    tmp_path: Path, bags: Path, program: Sequence[str], number: signal.Signals
) -> None:
    mark = uuid.uuid4().hex
    # With SIGINT ignored, as a background job of a script starts it.
    command = ['sh', '-c', 'trap "" INT; exec "$@"', 'sh', sys.executable, '-m', *program]
    if program is DEMO:
        command.append(str(bags))
    environment = {**os.environ, MARK: mark}
    with subprocess.Popen(
        command, cwd=tmp_path, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.STDOUT
    ) as process:
        try:
            wait_until(lambda: has_node(mark) or process.poll() is not None, LIMIT_SEC)
            assert has_node(mark), f'no node was started; exit code {process.poll()}'
            process.send_signal(number)
            assert process.wait(LIMIT_SEC) == INTERRUPTED
        finally:
            process.kill()
    assert commands_marked(mark) == []
