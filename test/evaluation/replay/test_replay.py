"""A small simulated bag through the replay."""

import csv
import dataclasses
import json

import numpy as np
import pytest

from spatial_relations_ros.core import BagError, ConfigError
from spatial_relations_ros.evaluation.bag_reader import read_frames
from spatial_relations_ros.evaluation.bag_writer import BagWriter
from spatial_relations_ros.evaluation.replay import ReplayOptions, replay_bag
from spatial_relations_ros.evaluation.replay_report import (
    CSV_COLUMNS,
    report_content,
    report_csv,
    timing_content,
)
from spatial_relations_ros.imitation import ImitationOptions
from spatial_relations_ros.learning import load_metric
from spatial_relations_ros.pipeline import LibraryModels, Pipeline

from .recorded import ASKED, NUM_CLOUDS, OBJECTS, SETTLED, START_NS, STEP_NS


@pytest.fixture(scope='module')
def metric(recorded):
    return load_metric(recorded / 'w.safetensors')


def fresh_pipeline(recorded):
    return Pipeline(models=LibraryModels(recorded / 'models', num_points=1000))


@pytest.fixture(scope='module')
def report(recorded, metric):
    return replay_bag(recorded / 'bag', fresh_pipeline(recorded), metric, ASKED)


def test_every_cloud_becomes_a_frame(report):
    assert [frame.frame_idx for frame in report.frames] == list(range(NUM_CLOUDS))
    assert [frame.stamp_ns - START_NS for frame in report.frames] == [
        idx * STEP_NS for idx in range(NUM_CLOUDS)
    ]
    assert report.dropped == ()
    for frame in report.frames[:-1]:
        assert set(frame.object_ids) == set(OBJECTS), frame.rejected


def test_imitates_in_the_frames_asked_for(report, recorded, metric):
    made = [frame.frame_idx for frame in report.frames if frame.imitation is not None]
    assert made[0] == 0
    assert all(idx % 3 == 0 for idx in made)
    options = dataclasses.replace(ASKED, frame_idxs=(1,))
    again = replay_bag(recorded / 'bag', fresh_pipeline(recorded), metric, options)
    made = [frame.frame_idx for frame in again.frames if frame.imitation is not None]
    assert made == [1]


def test_the_replay_sees_what_live_would_see(recorded):
    """Scenes are those that the pipeline makes of the same frames."""
    replayed = {}

    def keep(frame, result):
        replayed[frame.frame_idx] = result

    replay_bag(recorded / 'bag', fresh_pipeline(recorded), on_frame=keep)
    pipeline = fresh_pipeline(recorded)
    for frame_idx, frame in enumerate(read_frames(recorded / 'bag')):
        result, other = pipeline.step(frame), replayed[frame_idx]
        assert result.table_height == other.table_height
        assert set(result.objects) == set(other.objects)
        for object_id, item in result.objects.items():
            assert np.array_equal(item.points, other.objects[object_id].points)
            poses = (item.world_from_object, other.objects[object_id].world_from_object)
            assert np.array_equal(*(pose.as_matrix() for pose in poses))


def test_imitates_at_the_times_asked_for(recorded, metric):
    options = dataclasses.replace(ASKED, at_sec=(0.25, 0.3, 7.0))
    report = replay_bag(recorded / 'bag', fresh_pipeline(recorded), metric, options)
    made = [frame.frame_idx for frame in report.frames if frame.imitation is not None]
    assert made == [2]
    assert [request.frame_idx for request in report.requests] == [2, 2, None]
    entries = report_content(report)['requests']
    assert entries[2] == {'at_sec': 7.0, 'frame': None}


def test_imitates_each_demonstration_once(recorded, metric):
    """A second of a relation that holds still; the can is lost in the last of all clouds."""
    options = dataclasses.replace(ASKED, demonstrations=True)
    report = replay_bag(recorded / 'bag', fresh_pipeline(recorded), metric, options)
    made = [frame.frame_idx for frame in report.frames if frame.imitation is not None]
    assert made == [SETTLED]
    (found,) = report_content(report)['demonstrations']
    assert (found['first_frame'], found['settled_frame']) == (0, SETTLED)
    assert (found['last_frame'], found['imitated_frames']) == (NUM_CLOUDS - 1, [SETTLED])


def test_a_replay_keeps_the_clouds_of_imitations_only(report):
    for frame in report.frames:
        assert (frame.scenes is None) == (frame.imitation is None)


def test_the_same_input_gives_the_same_bytes(report, recorded, metric):
    again = replay_bag(recorded / 'bag', fresh_pipeline(recorded), metric, ASKED)
    assert json.dumps(report_content(again)) == json.dumps(report_content(report))
    assert report_csv(again) == report_csv(report)


def test_wall_times_are_kept_apart(report):
    text = json.dumps(report_content(report))
    assert 'sec' not in text.replace('second', '')
    assert 'duration' not in text
    timing = timing_content(report)
    assert timing['perception']['num'] == NUM_CLOUDS
    assert 0.0 < timing['imitation']['median'] < 1e3


def test_csv_has_a_row_for_each_frame(report):
    rows = list(csv.DictReader(report_csv(report).splitlines()))
    assert len(rows) == NUM_CLOUDS
    assert tuple(rows[0]) == CSV_COLUMNS
    first = report.frames[0].imitation.answers[0]
    assert float(rows[0]['tx']) == pytest.approx(
        first.placements[1].target.translation[0], abs=1e-5
    )
    assert rows[1]['imitated'] == '0'


def test_missing_objects_have_a_reason(recorded, metric):
    options = dataclasses.replace(ASKED, test_ids=('carton', 'teapot'))
    report = replay_bag(recorded / 'bag', fresh_pipeline(recorded), metric, options)
    assert all(frame.distance is None for frame in report.frames)
    assert all('teapot' in frame.reason for frame in report.frames)
    content = report_content(report)
    assert content['summary']['num_comparable'] == 0
    assert 'known objects: ' in content['frames'][0]['reason']


def test_perception_alone_needs_no_metric(recorded):
    report = replay_bag(recorded / 'bag', fresh_pipeline(recorded))
    assert report.model_hash is None
    assert all(frame.imitation is None for frame in report.frames)


def test_requests_that_make_no_sense(recorded):
    with pytest.raises(ConfigError, match='both'):
        ReplayOptions(reference_ids=('a', 'b'))
    with pytest.raises(ConfigError, match='time budget'):
        ReplayOptions(imitation=ImitationOptions(time_budget_sec=1.0))
    with pytest.raises(ConfigError, match='metric'):
        replay_bag(recorded / 'bag', Pipeline(), None, ASKED)


def test_a_bag_whose_clouds_cannot_be_used(tmp_path):
    with BagWriter(tmp_path / 'bag') as writer:
        empty = np.full((2, 3, 3), np.nan, dtype=np.float32)
        cloud = writer.cloud(START_NS, 'camera', empty, np.zeros((2, 3, 3), dtype=np.uint8))
        cloud.point_step = 0
        writer.write('/points', START_NS, cloud)
    with pytest.raises(BagError, match=r'no cloud on /points .* can be used'):
        replay_bag(tmp_path / 'bag', Pipeline())
