"""Cancelling goals over DDS, timed: the command with its real node and a few goals."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from spatial_relations_ros.nodes.cancel_timing import main

pytestmark = pytest.mark.ros


def test_every_goal_is_timed_or_told_to_be_late(tmp_path: Path) -> None:
    results = tmp_path / 'cancel.json'
    assert main(['--cancels', '3', '--whole', '2', '--json', str(results)]) == 0
    summary = json.loads(results.read_text())
    assert summary['whole']['count'] == 2
    # Goals that were over before their cancellation came do not count.
    assert summary['cancels']['count'] == 3
    assert summary['late'] >= 0
    cancels, whole = summary['cancels'], summary['whole']
    assert 0.0 < cancels['p50_ms'] <= cancels['p90_ms'] <= cancels['max_ms']
    # A cancelled goal does not go on to its end.
    assert cancels['p50_ms'] < whole['p50_ms']
    assert summary['feedback']['count'] > 0


@pytest.mark.parametrize('option', ['--cancels', '--whole'])
def test_no_goals_are_refused(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main([option, '0'])
    assert '0 asked for; expected 1 or more' in capsys.readouterr().err
