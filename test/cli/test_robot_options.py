"""Obstacles, reach, grasps and the way in, from the command line."""

import json

import numpy as np
import open3d as o3d
import pytest

from spatial_relations_ros.core import Pose
from spatial_relations_ros.core.rotations import matrix_from_quat_wxyz


@pytest.fixture
def imitate(relations, scene_files, weights, tmp_path):
    """Runs ``relations imitate`` shortly with further options; returns its result and JSON.

    The can hangs in the air: whatever the metric says, it must move to be feasible.
    """
    files = scene_files['test']
    poses = tmp_path / 'hanging.json'
    poses.write_text(
        json.dumps(
            {
                'base': {'t': [0, 0, 0.03], 'q_wxyz': [1, 0, 0, 0]},
                'relative': {'t': [0.2, 0.05, 0.3], 'q_wxyz': [1, 0, 0, 0]},
            }
        )
    )

    def run(*options):
        out = tmp_path / 'result.json'
        result = relations(
            'imitate', *scene_files['reference'].options('reference'),
            '--test-base', files.base, '--test-relative', files.relative, '--test-poses', poses,
            '--weights', weights, '--steps', '0', '--json', out, *options,
        )  # fmt: skip
        return result, json.loads(out.read_text()) if out.exists() else None

    return run


def pose_of(entry):
    return Pose(np.array(entry['t']), np.array(entry['q_wxyz']))


def write_cloud(path, points):
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    assert o3d.io.write_point_cloud(str(path), cloud)


def test_grasp_order_and_approach_are_in_the_json(imitate, tmp_path):
    grasp = tmp_path / 'grasp.json'
    grasp.write_text(json.dumps({'relative': {'t': [0, 0, 0.1], 'q_wxyz': [0, 1, 0, 0]}}))
    result, content = imitate('--grasp', grasp, '--approach-height', '0.2')
    assert result.exit_code in (0, 1), result.output
    answer = content['answers'][0]
    target = answer['targets']['relative']
    pose, gripper = pose_of(answer['poses']['relative']), pose_of(target['gripper'])
    expected = pose @ Pose(np.array([0, 0, 0.1]), np.array([0.0, 1, 0, 0]))
    assert gripper.is_close(expected, metres=1e-6, angle_rad=1e-6)
    way = pose_of(target['approach']).translation - pose.translation
    assert np.linalg.norm(way) == pytest.approx(0.2, abs=1e-6)
    gripper_way = pose_of(target['gripper_approach']).translation - gripper.translation
    np.testing.assert_allclose(gripper_way, way, atol=1e-6)
    assert answer['targets']['base']['gripper'] is None
    assert answer['order'] == [{'role': 'relative', 'to': 'target'}]


def test_obstacles_are_kept_clear_of(imitate, tmp_path):
    """A cloud that fills all the room above the table leaves nothing feasible."""
    rng = np.random.default_rng(0)
    points = rng.uniform([-0.5, -0.5, 0.0], [0.5, 0.5, 0.4], (60_000, 3))
    points[0] = np.nan  # as cameras give them
    write_cloud(tmp_path / 'clutter.pcd', points)
    free, free_content = imitate()
    filled, content = imitate('--obstacles', tmp_path / 'clutter.pcd')
    assert filled.exit_code == 1
    assert not any(answer['feasible'] for answer in content['answers'])
    assert any(answer['feasible'] for answer in free_content['answers']), free.output


def test_reach_is_told(imitate):
    result, content = imitate('--shoulder', '3,0,0', '--shoulder', '-3,0,0')
    assert result.exit_code == 1
    assert not content['answers'][0]['targets']['relative']['reachable']
    _, near = imitate('--shoulder', '0.2,0.05,0.9', '--reach-min', '0.1', '--reach-max', '1.5')
    assert near['answers'][0]['targets']['relative']['reachable']


@pytest.mark.parametrize(
    ('options', 'message'),
    [
        (['--shoulder', '1,2'], 'expected X,Y,Z'),
        (['--shoulder', 'a,b,c'], 'expected X,Y,Z'),
        (['--shoulder', 'nan,0,0'], 'expected x, y, z'),
        (['--reach-max', '1'], 'need --shoulder'),
        (['--shoulder', '0,0,0', '--reach-min', '2'], 'reach is 2.0 to 0.85'),
        (['--obstacles', 'none.pcd'], 'none.pcd does not exist'),
        (['--grasp', 'none.json'], 'none.json cannot be read'),
        (['--grasp', 'EMPTY'], 'holds no grasp'),
        (['--grasp', 'WRONG'], "unknown entry 'mug'"),
    ],
)
def test_bad_input_says_what_would_work(imitate, tmp_path, options, message):
    places = {'EMPTY': tmp_path / 'empty.json', 'WRONG': tmp_path / 'wrong.json'}
    places['EMPTY'].write_text('{}')
    places['WRONG'].write_text('{"mug": {"t": [0, 0, 0], "q_wxyz": [1, 0, 0, 0]}}')
    result, content = imitate(*(places.get(option, option) for option in options))
    assert result.exit_code == 2, result.output
    assert message in result.stderr
    assert content is None


def test_the_gripper_of_the_example_points_down():
    """The example of the documentation: turned half around x."""
    rotation = matrix_from_quat_wxyz(np.array([0.0, 1.0, 0.0, 0.0]))
    np.testing.assert_allclose(rotation @ [0, 0, 1], [0, 0, -1], atol=1e-12)
