"""The live benchmark with its real processes, for two seconds at a low rate."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from spatial_relations_ros.nodes.live_bench.__main__ import main

pytestmark = pytest.mark.ros

RATE, SECONDS = 5.0, 2.0


def test_every_cloud_is_accounted_for(tmp_path: Path) -> None:
    results, table = tmp_path / 'live.json', tmp_path / 'live.md'
    arguments = [
        '--stream', 'sd', '--rate', str(RATE), '--duration', str(SECONDS), '--reliable',
        '--json', str(results), '--markdown', str(table),
    ]  # fmt: skip
    code = main(arguments)
    (run,) = json.loads(results.read_text())['runs']
    assert run['sent'] == RATE * SECONDS
    assert run['received'] >= run['handled'] >= run['clouds_with_all_scenes'] > 0
    assert run['sent'] >= run['received']
    # A machine that is too busy for five clouds a second loses some, and the command says so.
    assert code == (1 if run['problems'] else 0)
    assert 0.0 < run['latency_ms']['median'] <= run['latency_ms']['p99']
    assert run['age_ms']['median'] > run['latency_ms']['median']
    assert run['cpu_share'] > 0.0
    assert len(run['memory_mb']) > 10
    assert table.read_text().count('\n') == 3
