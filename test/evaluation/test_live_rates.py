"""What the live benchmark makes of its measurements."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.evaluation.live_rates import (
    COLUMNS,
    LiveRun,
    growth_per_minute,
    markdown_table,
    run_entry,
)
from spatial_relations_ros.evaluation.live_stream import (
    FORMATS,
    TRACKED_IDS,
    render_stream,
    stream_format,
)
from spatial_relations_ros.perception.point_cloud2 import PointCloud

RUN = LiveRun(
    stream='sd',
    rate=30.0,
    megabytes_per_second=104.2,
    duration_sec=20.0,
    num_sent=600,
    num_received=600,
    num_handled=600,
    num_scenes_of=600,
    latency_ms=(6.0, 10.0, 15.0),
    ages_ms=tuple(float(value) for value in range(1, 101)),
    cpu_sec=6.0,
    memory_mb=tuple((float(sec), 500.0) for sec in range(20)),
    max_late_ms=1.0,
)


def test_a_run_without_loss_has_no_problems():
    assert RUN.problems == []
    assert RUN.cpu_share == pytest.approx(0.3)
    assert RUN.age_ms == pytest.approx((50.5, 99.01))


@pytest.mark.parametrize(
    ('loss', 'words'),
    [
        ({'num_received': 599, 'num_handled': 599, 'num_scenes_of': 599}, '1 clouds were not rec'),
        ({'num_handled': 590, 'num_scenes_of': 590}, '10 clouds were not handled'),
        ({'num_scenes_of': 598}, 'of 2 clouds no scenes'),
    ],
)
def test_every_kind_of_loss_is_a_problem_once(loss, words):
    (problem,) = dataclasses.replace(RUN, **loss).problems
    assert words in problem


def test_memory_that_is_filled_once_is_no_growth_and_a_leak_is():
    seconds = np.arange(0.0, 120.0)
    filled = 500.0 + 50.0 * np.minimum(seconds / 30.0, 1.0)
    assert growth_per_minute(list(zip(seconds, filled, strict=True))) == pytest.approx(0.0)
    leaking = filled + 0.1 * seconds
    assert growth_per_minute(list(zip(seconds, leaking, strict=True))) == pytest.approx(6.0)
    assert math.isnan(growth_per_minute([(0.0, 1.0)]))


def test_the_table_has_a_cell_for_each_column():
    lines = markdown_table([RUN, RUN]).splitlines()
    assert len(lines) == 4
    assert {line.count('|') for line in lines} == {len(COLUMNS) + 1}
    assert run_entry(RUN)['age_ms']['median'] == pytest.approx(50.5)


def test_a_stream_is_the_rendered_table_in_the_layout_asked_for(tmp_path):
    layout = FORMATS['sd']
    stream = render_stream(layout, tmp_path)
    assert stream.clouds.shape[1:] == (424, 512 * 16)
    assert stream.clouds[0].size == layout.num_bytes
    assert set(stream.poses) == set(TRACKED_IDS)
    assert {path.stem for path in tmp_path.iterdir()} == set(TRACKED_IDS)
    xyz = stream.clouds.view('<f4').reshape(len(stream.clouds), 424, 512, 4)[..., :3]
    assert 0.7 < PointCloud(xyz[0]).finite.mean() < 1.0
    # Noise differs from cloud to cloud.
    assert np.nanmax(np.abs(xyz[0] - xyz[1])) > 0.001


def test_an_unknown_stream_is_refused_with_those_that_are():
    with pytest.raises(ConfigError, match='expected one of sd, sd32, qhd, hd'):
        stream_format('4k')
