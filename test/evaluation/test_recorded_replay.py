"""A replay in a Rerun recording, read back."""

from __future__ import annotations

import numpy as np
import pytest

from spatial_relations_ros.evaluation.bag_reader import BagTopics
from spatial_relations_ros.evaluation.recorded_replay import record_replay
from spatial_relations_ros.evaluation.replay import ReplayedFrame, ReplayOptions, ReplayReport
from spatial_relations_ros.perception.border import FrameResult
from spatial_relations_ros.visualization.recordings import Recording


def test_objects_reasons_and_distances_stand_at_the_bags_times(solids, tmp_path):
    rerun = pytest.importorskip('rerun', reason='needs rerun-sdk (extra viz)')
    objects = {
        name: solids.box(name, (0.1, 0.1, 0.1), (x, 0.0, 0.05))
        for name, x in (('plate', 0.0), ('cup', 0.2), ('tray', 0.4), ('mug', 0.6))
    }
    seen = FrameResult(2_000_000_000, 'world', objects)
    lost = FrameResult(2_500_000_000, 'world', {}, {'mug': 'it has no support'})
    report = ReplayReport(
        'bag',
        BagTopics('/points', ()),
        None,
        ReplayOptions(('plate', 'cup'), ('tray', 'mug')),
        (
            ReplayedFrame(0, seen, distance=1.5),
            ReplayedFrame(1, lost, reason='mug: it has no support'),
        ),
        (),
    )
    path = tmp_path / 'out.rrd'
    with Recording(str(path)) as recording:
        record_replay(recording, report, None)
    chunks = rerun.chunk.RrdReader(str(path)).stream().to_chunks()
    batches = {chunk.entity_path: chunk.to_record_batch() for chunk in chunks}
    assert {'/objects/plate', '/objects/mug', '/distance', '/log', '/log/mug'} <= set(batches)
    assert batches['/distance'].column('frame').to_pylist() == [0]
    log = batches['/log/mug']
    assert log.column('frame').to_pylist() == [1]
    seconds = np.array(log.column('bag_time').cast('int64')) / 1e9
    np.testing.assert_allclose(seconds, [0.5])
    (text,) = (name for name in log.schema.names if name.endswith(':text'))
    assert log.column(text).to_pylist() == [['it has no support']]
