"""ICP on the cloud of a simulated Kinect2."""

import math

import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError, Pose
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.perception.camera import estimate_camera
from spatial_relations_ros.perception.config import PerceptionConfig
from spatial_relations_ros.perception.evidence import support_at
from spatial_relations_ros.perception.object_models import KnownModel
from spatial_relations_ros.perception.point_cloud2 import PointCloud
from spatial_relations_ros.perception.refine import PoseRefiner, RefineConfig
from spatial_relations_ros.perception.scene_perception import ScenePerception
from spatial_relations_ros.perception.table import Plane
from spatial_relations_ros.perception.view import View

TABLE = Plane(np.array([0.0, 0.0, 1.0]), 0.7)


def view_of(tabletop):
    cloud = tabletop.cloud
    return View(cloud, estimate_camera(cloud), tabletop.world_from_camera.as_matrix(), TABLE)


def moved(pose, shift, degrees=0.0):
    turn = matrix_from_rotvec(np.deg2rad([degrees, -degrees, degrees]) / math.sqrt(3))
    rotation = turn @ pose.rotation
    return Pose.from_rotation(rotation, pose.translation + np.array(shift))


def error(pose, truth):
    delta = truth.inverse() @ pose
    angle = 2 * math.acos(min(1.0, abs(delta.quat_wxyz[0])))
    return np.linalg.norm(delta.translation), math.degrees(angle)


@pytest.mark.parametrize('object_id', ['base', 'tall'])
@pytest.mark.parametrize(
    'shift', [(0.012, 0, 0), (0, -0.012, 0), (0, 0, 0.012), (0.007, 0.007, -0.007)]
)
def test_a_pose_beside_the_object_is_moved_onto_it(tabletop, object_id, shift):
    truth = tabletop.poses[object_id]
    start = moved(truth, shift, degrees=3.0)
    others = [(tabletop.find(key), tabletop.poses[key]) for key in ('top',)]
    model, view = tabletop.find(object_id), view_of(tabletop)
    refined = PoseRefiner().refined(model, start, view, others)
    metres, degrees = error(refined, truth)
    assert metres < 0.006
    assert degrees < 1.0
    # The faces across y are seen at a grazing angle, or not at all.
    offset = refined.translation - truth.translation
    assert abs(offset[0]) < 0.001
    assert abs(offset[2]) < 0.001
    config = RefineConfig()
    assert support_at(model.support_points, refined, view, config.tolerance) > support_at(
        model.support_points, start, view, config.tolerance
    )


def test_a_cloud_serves_as_model_too(tabletop):
    model = KnownModel(tabletop.find('tall').points)
    truth = tabletop.poses['tall']
    refined = PoseRefiner().refined(model, moved(truth, (0.0, 0.01, 0.0)), view_of(tabletop))
    assert error(refined, truth)[0] < 0.005


@pytest.mark.parametrize('place', [(0, 0, 1.0), (1e200, 0, 0), (-0.7, 0.0, 1.5), (30.0, 0, 0)])
def test_a_pose_where_nothing_is_stays_as_it_is(tabletop, place):
    pose = Pose(np.array(place, dtype=float))
    assert PoseRefiner().refined(tabletop.find('tall'), pose, view_of(tabletop)) is pose


def test_a_correction_is_refused_that_is_too_large(tabletop):
    model, truth, view = tabletop.find('tall'), tabletop.poses['tall'], view_of(tabletop)
    start = moved(truth, (0.01, 0.0, 0.0), degrees=4.0)
    assert PoseRefiner().refined(model, start, view) is not start
    assert PoseRefiner(RefineConfig(max_turn_rad=0.01)).refined(model, start, view) is start


def test_support_never_falls(tabletop):
    rng = np.random.default_rng(0)
    model, view, tolerance = tabletop.find('tall'), view_of(tabletop), RefineConfig().tolerance
    for _ in range(10):
        start = moved(tabletop.poses['tall'], rng.normal(0, 0.02, 3), rng.normal(0, 10))
        refined = PoseRefiner().refined(model, start, view)
        before, after = (
            support_at(model.support_points, pose, view, tolerance) for pose in (start, refined)
        )
        assert refined is start or after > before or math.isnan(before)


def test_without_a_camera_nothing_is_refined(tabletop):
    pose = tabletop.poses['tall']
    view = View(PointCloud(tabletop.cloud.points), None, np.eye(4), TABLE)
    assert PoseRefiner().refined(tabletop.find('tall'), pose, view) is pose


def test_the_step_gives_refined_poses_where_asked_for(tabletop):
    tracks = [tabletop.track(key, offset=(0.01, 0.0, 0.0)) for key in tabletop.poses]
    frame = tabletop.frame(tracks)
    found = {}
    for is_on in (False, True):
        config = PerceptionConfig(refine=RefineConfig(is_on=is_on))
        objects = ScenePerception(config, tabletop).step(frame).objects
        found[is_on] = {
            key: error(item.world_from_object, tabletop.poses[key])[0]
            for key, item in objects.items()
        }
    assert all(metres == pytest.approx(0.01) for metres in found[False].values())
    assert all(metres < 0.007 for metres in found[True].values())


def test_the_same_cloud_gives_the_same_pose(tabletop):
    start = moved(tabletop.poses['tall'], (0.01, 0.0, 0.0), degrees=2.0)
    first, second = (
        PoseRefiner().refined(tabletop.find('tall'), start, view_of(tabletop)) for _ in range(2)
    )
    np.testing.assert_array_equal(first.as_matrix(), second.as_matrix())


@pytest.mark.parametrize('wrong', [{'reach': 0.0}, {'num_points': 3}, {'max_turn_rad': 0.0}])
def test_refuses_impossible_settings(wrong):
    with pytest.raises(ConfigError):
        RefineConfig(**wrong)
