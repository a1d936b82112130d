"""A replay in a Rerun recording, read back."""

from __future__ import annotations

import numpy as np
import pytest

from spatial_relations_ros.core import Scene
from spatial_relations_ros.evaluation.bag_reader import BagTopics
from spatial_relations_ros.evaluation.recorded_replay import record_replay
from spatial_relations_ros.evaluation.replay import ReplayedFrame, ReplayOptions, ReplayReport
from spatial_relations_ros.imitation import ImitationAnswer, ImitationResult, ObjectPlacement
from spatial_relations_ros.visualization.recordings import Recording


def stays(item):
    pose = item.world_from_object
    return ObjectPlacement(item.object_id, pose, pose, pose, True, 0.0, True)


def test_scenes_reasons_and_distances_stand_at_the_bags_times(solids, tmp_path):
    rerun = pytest.importorskip('rerun', reason='needs rerun-sdk (extra viz)')
    plate, cup, tray, mug = (
        solids.box(name, (0.1, 0.1, 0.1), (0.2 * idx, 0.0, 0.05))
        for idx, name in enumerate(('plate', 'cup', 'tray', 'mug'))
    )
    answer = ImitationAnswer((stays(tray), stays(mug)), 0.5, 0.9, True, ())
    result = ImitationResult(True, 'good', (answer,), np.array([1.5, 0.5]), 1.5, 0.1, 1)
    seen = ReplayedFrame(
        0, 2_000_000_000, ('cup', 'mug', 'plate', 'tray'), {}, {}, None, 0.0, 1.5,
        scenes=(Scene(plate, cup), Scene(tray, mug)), imitation=result,
    )  # fmt: skip
    lost = ReplayedFrame(
        1, 2_500_000_000, (), {}, {'mug': 'it has no support'}, None, None, reason='mug is lost'
    )
    options = ReplayOptions(('plate', 'cup'), ('tray', 'mug'))
    report = ReplayReport('bag', BagTopics('/points', ()), None, options, (seen, lost), ())
    path = tmp_path / 'out.rrd'
    with Recording(str(path)) as recording:
        record_replay(recording, report, None, path=('bag',))
    chunks = rerun.chunk.RrdReader(str(path)).stream().to_chunks()
    batches = {chunk.entity_path: chunk.to_record_batch() for chunk in chunks}
    assert {'/bag/reference/plate', '/bag/test/mug', '/bag/targets/mug', '/bag/log'} <= set(
        batches
    )
    for name in ('/bag/distance', '/bag/answer/distance', '/bag/answer/feasible'):
        assert batches[name].column('frame').to_pylist() == [0]
    log = batches['/bag/log/mug']
    assert log.column('frame').to_pylist() == [1]
    np.testing.assert_allclose(np.array(log.column('bag_time').cast('int64')) / 1e9, [0.5])
    (text,) = (name for name in log.schema.names if name.endswith(':text'))
    assert log.column(text).to_pylist() == [['it has no support']]
