"""A small simulated bag through the replay and the command."""

import csv
import dataclasses
import json

import numpy as np
import pytest
import torch

from spatial_relations_ros.core import BagError, ConfigError, Pose, TriangleMesh
from spatial_relations_ros.datasets.kinect_simulator import (
    KinectSimulator,
    Surface,
    look_at,
    table_mesh,
)
from spatial_relations_ros.datasets.object_files import save_mesh
from spatial_relations_ros.evaluation.bag_writer import BagWriter
from spatial_relations_ros.evaluation.replay import ReplayOptions, replay_bag
from spatial_relations_ros.evaluation.replay_report import (
    CSV_COLUMNS,
    report_content,
    report_csv,
    timing_content,
)
from spatial_relations_ros.imitation import ImitationOptions
from spatial_relations_ros.learning import ModelCard, load_metric, make_encoder, save_metric
from spatial_relations_ros.perception.border import StampedTransform, TrackedPose
from spatial_relations_ros.perception.camera import PinholeCamera
from spatial_relations_ros.pipeline import LibraryModels, Pipeline

CAMERA = PinholeCamera(160, 120, fx=110.0, fy=110.0, cx=79.5, cy=59.5)
WORLD_FROM_CAMERA = look_at((0.0, -1.0, 0.8), (0.0, 0.0, 0.0))
OBJECTS = {
    'tray': ((0.24, 0.18, 0.02), (-0.25, 0.0, 0.01)),
    'cup': ((0.06, 0.06, 0.1), (-0.25, 0.0, 0.07)),
    'carton': ((0.14, 0.1, 0.06), (0.2, 0.0, 0.03)),
    'can': ((0.06, 0.06, 0.08), (0.4, -0.05, 0.04)),
}
NUM_CLOUDS = 4
START_NS = 1_700_000_000_000_000_000
STEP_NS = 200_000_000
ASKED = ReplayOptions(
    reference_ids=('tray', 'cup'),
    test_ids=('carton', 'can'),
    every=3,
    imitation=ImitationOptions(max_steps=1, num_starts=1, propose=False),
)


def box_mesh(size):
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2.0
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = [t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])]
    return TriangleMesh(corners * np.asarray(size), np.array(triangles))


@pytest.fixture(scope='module')
def recorded(tmp_path_factory):
    """Folder with ``bag``, ``models`` and ``w.safetensors``; the can is lost in the last cloud."""
    folder = tmp_path_factory.mktemp('replay')
    poses = {name: Pose(np.array(place)) for name, (_, place) in OBJECTS.items()}
    meshes = {name: box_mesh(size) for name, (size, _) in OBJECTS.items()}
    for name, mesh in meshes.items():
        save_mesh(folder / 'models' / f'{name}.ply', mesh)
    surfaces = [Surface(table_mesh((1.6, 1.0)))]
    surfaces += [Surface(mesh.transformed(poses[name])) for name, mesh in meshes.items()]
    simulator = KinectSimulator(surfaces, WORLD_FROM_CAMERA, CAMERA)
    rng = np.random.default_rng(0)
    camera_from_world = WORLD_FROM_CAMERA.inverse()
    with BagWriter(folder / 'bag') as writer:
        mount = StampedTransform('world', 'camera', START_NS, WORLD_FROM_CAMERA, is_static=True)
        writer.write('/tf_static', START_NS, writer.transforms([mount]))
        for cloud_idx in range(NUM_CLOUDS):
            stamp = START_NS + cloud_idx * STEP_NS
            tracks = [
                TrackedPose(name, stamp, 'camera', camera_from_world @ pose)
                for name, pose in poses.items()
                if not (name == 'can' and cloud_idx == NUM_CLOUDS - 1)
            ]
            objects = writer.tracked_objects(stamp, 'camera', tracks)
            writer.write('/tracked_objects', stamp + 1, objects)
            image = simulator.measure(rng)
            cloud = writer.cloud(stamp, 'camera', simulator.xyz(image), image.rgb)
            writer.write('/points', stamp + 2, cloud)
    torch.manual_seed(0)
    encoder = make_encoder('compact')
    save_metric(encoder, ModelCard('compact', num_points=256), folder / 'w.safetensors')
    return folder


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
    assert [frame.result.stamp_ns - START_NS for frame in report.frames] == [
        idx * STEP_NS for idx in range(NUM_CLOUDS)
    ]
    assert report.dropped == ()
    for frame in report.frames[:-1]:
        assert set(frame.result.objects) == set(OBJECTS), frame.result.rejected


def test_imitates_in_the_frames_asked_for(report, recorded, metric):
    made = [frame.frame_idx for frame in report.frames if frame.imitation is not None]
    assert made[0] == 0
    assert all(idx % 3 == 0 for idx in made)
    options = dataclasses.replace(ASKED, frame_idxs=(1,))
    again = replay_bag(recorded / 'bag', fresh_pipeline(recorded), metric, options)
    made = [frame.frame_idx for frame in again.frames if frame.imitation is not None]
    assert made == [1]


def test_the_replay_sees_what_live_would_see(report, recorded):
    """Distances are those of the scenes that the pipeline makes of the same frames."""
    from spatial_relations_ros.evaluation.bag_reader import read_frames

    pipeline = fresh_pipeline(recorded)
    for frame, replayed in zip(read_frames(recorded / 'bag'), report.frames, strict=True):
        result = pipeline.step(frame)
        assert result.table_height == replayed.result.table_height
        for object_id, item in result.objects.items():
            other = replayed.result.objects[object_id]
            assert np.array_equal(item.points, other.points)
            assert item.world_from_object.is_close(other.world_from_object)


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


def test_the_command_writes_the_same_files_twice(recorded, tmp_path):
    from typer.testing import CliRunner

    from spatial_relations_ros.cli.main import app

    for name in ('first', 'second'):
        result = CliRunner().invoke(
            app,
            [
                'replay', str(recorded / 'bag'), '--models', str(recorded / 'models'),
                '--json', str(tmp_path / f'{name}.json'), '--csv', str(tmp_path / f'{name}.csv'),
                '--timing', str(tmp_path / 'timing.json'),
            ],
        )  # fmt: skip
        assert result.exit_code == 0, result.output
        assert f'{NUM_CLOUDS} frames' in result.output
    for suffix in ('json', 'csv'):
        first, second = (tmp_path / f'{name}.{suffix}' for name in ('first', 'second'))
        assert first.read_bytes() == second.read_bytes()
    assert json.loads((tmp_path / 'timing.json').read_text())['perception']['num'] == NUM_CLOUDS


def test_the_command_fails_when_nothing_can_be_imitated(recorded):
    from typer.testing import CliRunner

    from spatial_relations_ros.cli.main import app

    result = CliRunner().invoke(
        app,
        [
            'replay', str(recorded / 'bag'), '--models', str(recorded / 'models'),
            '--reference', 'tray', 'cup', '--test', 'carton', 'teapot',
            '--weights', str(recorded / 'w.safetensors'),
        ],
    )  # fmt: skip
    assert result.exit_code == 1
    assert 'teapot' in result.output
