"""Recordings are read back with Rerun's own reader."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.visualization.recorded_imitation import record_imitation
from spatial_relations_ros.visualization.recordings import Recording, check_target


def projections(scene):
    return np.full((3, 2, 20, 20), 120.0, dtype=np.float32)


def columns_of(path):
    """Entity to timeline to numbers of the rows, and scalars where it has them."""
    rerun = pytest.importorskip('rerun', reason='needs rerun-sdk (extra viz)')
    reader = rerun.chunk.RrdReader(str(path))
    (entry,) = reader.recordings()
    assert entry.application_id == 'spatial_relations_ros'
    found = {}
    for chunk in reader.stream().to_chunks():
        batch = chunk.to_record_batch()
        kept = found.setdefault(chunk.entity_path, {})
        for name, values in zip(batch.schema.names, batch.columns, strict=True):
            if name != 'log_time':
                kept.setdefault(name, []).extend(values.to_pylist())
    return found


def test_scenes_projections_and_curves_are_read_back(shown, tmp_path):
    pytest.importorskip('rerun', reason='needs rerun-sdk (extra viz)')
    path = tmp_path / 'out.rrd'
    with Recording(str(path), name='one') as recording:
        record_imitation(recording, shown, projections=projections)
    found = columns_of(path)
    assert {
        '/reference/plate', '/reference/mug', '/test/tray', '/test/cup', '/answers/1/cup',
        '/answers/2/cup', '/projections/reference', '/projections/test', '/distance',
        '/feasible', '/search', '/outcome',
    } <= set(found)  # fmt: skip
    assert found['/distance']['moment'] == [0, 1, 2]
    scalars = [key for key in found['/distance'] if 'Scalars' in key]
    assert [value for (value,) in found['/distance'][scalars[0]]] == [2.0, 1.0, 0.25]
    assert [value for (value,) in found['/feasible'][scalars[0]]] == [0.0, 1.0]
    assert found['/search']['step'] == [0, 1, 3], 'what is not a number is left out'
    moved = [key for key in found['/test/cup'] if 'Transform3D:translation' in key]
    places = [row[0] for row in found['/test/cup'][moved[0]] if row]
    np.testing.assert_allclose(places, [[0.3, 0, 0], [0.1, 0, 0.1], [0, 0, 0.1]], atol=1e-6)
    shapes = [key for key in found['/test/tray'] if 'Mesh3D:vertex_positions' in key]
    assert sum(bool(row) for row in found['/test/tray'][shapes[0]]) == 1, 'a shape is stored once'


@pytest.mark.parametrize('target', ['out.txt', 'http://127.0.0.1', 'spawn.html', ''])
def test_targets_that_are_none_are_refused(target):
    with pytest.raises(ConfigError, match=r'ends with \.rrd.*spawn.*address'):
        check_target(target)


def test_a_folder_that_is_absent_is_named_before_the_work(tmp_path):
    with pytest.raises(ConfigError, match='nowhere of the recording does not exist'):
        check_target(str(tmp_path / 'nowhere' / 'out.rrd'))


def test_without_rerun_the_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, 'rerun', None)
    with pytest.raises(ConfigError, match=r"pip install '(.+)', which") as refused:
        Recording(str(tmp_path / 'out.rrd'))
    assert list(tmp_path.iterdir()) == []
    requirement = str(refused.value).split("'")[-2]
    setup = Path(__file__).resolve().parents[2] / 'setup.py'
    assert f"'viz': ['{requirement}']" in setup.read_text(), 'what the extra asks for'
