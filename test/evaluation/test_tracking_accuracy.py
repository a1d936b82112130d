"""Support and refinement over the size of a pose's error."""

import json

import numpy as np
import pytest

from spatial_relations_ros.evaluation import tracking_accuracy
from spatial_relations_ros.evaluation.tracking_accuracy import (
    main,
    make_captures,
    refined_rows,
    support_rows,
)
from spatial_relations_ros.perception.evidence import SupportConfig


@pytest.fixture(scope='module')
def captures():
    return make_captures(1, seed=5)


def test_support_tells_wrong_poses_from_right_ones(captures):
    rows = support_rows(captures, SupportConfig(), repeats=2, seed=0)
    by_shift = {row.shift: row for row in rows}
    assert by_shift[0.01].refused_new == 0.0
    assert by_shift[0.12].refused_new > 0.9
    medians = [row.quantiles[1] for row in rows]
    assert all(np.diff(medians) < 0.02)
    assert rows == support_rows(captures, SupportConfig(), repeats=2, seed=0)


def test_refined_poses_are_nearer_to_the_truth(captures):
    for row in refined_rows(captures, repeats=1, seed=0):
        assert row.num_poses == 7
        assert row.after[0] < row.before[0]
        assert row.accepted > 0.5
        assert row.worse < 0.2


def test_the_command_writes_its_rows(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(tracking_accuracy, 'ERRORS', ((0.0, 0), (0.05, 10)))
    monkeypatch.setattr(tracking_accuracy, 'REFINED_ERRORS', ((0.01, 3),))
    out = tmp_path / 'rows.json'
    assert main(['--scenes', '1', '--repeats', '1', '--json', str(out)]) == 0
    content = json.loads(out.read_text())
    assert [row['shift'] for row in content['support']] == [0.0, 0.05]
    assert content['refined'][0]['num_poses'] == 7
    assert 'ADD-S' in capsys.readouterr().out
