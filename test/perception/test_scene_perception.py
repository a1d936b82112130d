"""The whole step, on the cloud of a simulated Kinect2."""

import dataclasses
import math

import numpy as np
import pytest

from spatial_relations_ros.core import CloudFormatError, CloudSource, ConfigError, Pose
from spatial_relations_ros.perception.border import StampedTransform, TrackFault
from spatial_relations_ros.perception.config import PerceptionConfig
from spatial_relations_ros.perception.evidence import SupportConfig
from spatial_relations_ros.perception.point_cloud2 import PointCloud
from spatial_relations_ros.perception.scene_perception import ScenePerception

STAMP_NS = 1_700_000_000_000_000_000
SEC = 1_000_000_000
TABLE_HEIGHT = 0.7


def step(tabletop, frame=None, *, models=True, **config):
    perception = ScenePerception(PerceptionConfig(**config), tabletop if models else None)
    return perception.step(frame or tabletop.frame())


def test_known_objects_are_put_in_the_world_and_confirmed(tabletop):
    result = step(tabletop)
    assert result.problem is None
    assert result.rejected == {}
    assert list(result.objects) == ['base', 'tall', 'top']
    for object_id, item in result.objects.items():
        assert item.world_from_object.is_close(tabletop.poses[object_id], metres=1e-9)
        assert item.source == CloudSource.MODEL
        assert item.mesh is tabletop.meshes[object_id]
        assert item.support > 0.9
    assert result.stamp_ns == STAMP_NS
    assert result.frame_id == 'world'


def test_the_table_is_found_and_not_the_larger_floor(tabletop):
    assert step(tabletop).table_height == pytest.approx(TABLE_HEIGHT, abs=0.003)


def test_objects_without_a_model_are_seen_where_they_are(tabletop):
    result = step(tabletop, models=False)
    assert set(result.objects) == {'base', 'tall', 'top'}
    for object_id, item in result.objects.items():
        assert item.source == CloudSource.OBSERVED
        assert math.isnan(item.support)
        half = np.abs(tabletop.meshes[object_id].vertices).max(axis=0)
        inside = (np.abs(item.points) < half + 0.02).all(axis=1).mean()
        assert inside > (0.97 if object_id == 'tall' else 0.6)
        # Two that touch are divided half way between their centres, hence the tolerances.
        assert item.points[:, 2].max() == pytest.approx(half[2], abs=0.015)


def test_an_unknown_object_on_a_known_one_is_told_apart(tabletop):
    class OnlyBase:
        def find(self, object_id):
            return tabletop.find(object_id) if object_id == 'base' else None

    result = ScenePerception(PerceptionConfig(), OnlyBase()).step(tabletop.frame())
    top = result.objects['top']
    assert top.source == CloudSource.OBSERVED
    assert top.world_points[:, 2].min() > TABLE_HEIGHT + 0.10
    assert result.objects['base'].source == CloudSource.MODEL


def test_a_tracker_that_lost_its_object_is_not_believed(tabletop):
    tracks = [tabletop.track('base'), tabletop.track('tall', offset=(-0.15, 0.12, 0.05))]
    result = step(tabletop, tabletop.frame(tracks))
    assert set(result.objects) == {'base'}
    assert 'no support in the cloud (' in result.rejected['tall']
    believed = step(tabletop, tabletop.frame(tracks), support=SupportConfig(min_support=0.0))
    assert believed.objects['tall'].support < 0.2


def test_obstacles_are_what_belongs_to_no_object(tabletop):
    result = step(tabletop, tabletop.frame([tabletop.track('base')]), find_obstacles=True)
    tall = tabletop.poses['tall'].translation
    near_tall = np.abs(result.obstacles - tall)[:, :2].max(axis=1) < 0.06
    assert near_tall.sum() > 40
    base = tabletop.poses['base'].translation
    assert not (np.abs(result.obstacles - base) < [0.08, 0.06, 0.05]).all(axis=1).any()
    assert step(tabletop).obstacles is None


def test_a_cloud_without_finite_points_gives_no_objects_but_a_reason(tabletop):
    blind = PointCloud(np.full((424, 512, 3), np.nan, dtype=np.float32))
    result = step(tabletop, tabletop.frame(cloud=blind))
    assert result.objects == {}
    assert result.problem == 'no finite points in the cloud of 217088'
    assert result.rejected['base'] == result.problem


def test_a_cloud_of_an_unknown_frame_gives_no_objects_but_a_reason(tabletop):
    result = step(tabletop, tabletop.frame(transforms=()))
    assert result.objects == {}
    assert "no transform from 'camera' to 'world'" in result.problem


def test_stale_poses_and_unreadable_ones_are_named(tabletop):
    tracks = [tabletop.track('base'), tabletop.track('tall', stamp_ns=STAMP_NS - 2 * SEC)]
    frame = dataclasses.replace(
        tabletop.frame(tracks), faults=(TrackFault('top', 'quaternion of norm 0'),)
    )
    result = step(tabletop, frame)
    assert set(result.objects) == {'base'}
    assert '2.00 s old' in result.rejected['tall']
    assert result.rejected['top'] == 'quaternion of norm 0'


def test_a_bad_model_costs_its_object_only(tabletop):
    class Damaged:
        def find(self, object_id):
            if object_id == 'tall':
                raise CloudFormatError('tall.ply: truncated')
            return tabletop.find(object_id)

    result = ScenePerception(PerceptionConfig(), Damaged()).step(tabletop.frame())
    assert set(result.objects) == {'base', 'top'}
    assert result.rejected['tall'] == 'its model cannot be used: tall.ply: truncated'


def test_objects_may_be_frames_of_tf(tabletop):
    tall = StampedTransform('world', 'tall', STAMP_NS, tabletop.poses['tall'])
    frame = tabletop.frame([], transforms=(tabletop.camera_transform(), tall))
    result = step(tabletop, frame, object_frames=('tall', 'ghost'))
    assert set(result.objects) == {'tall'}
    assert "nothing is known of 'ghost'" in result.rejected['ghost']


def test_a_bag_that_starts_again_gives_the_same_results_again(tabletop):
    perception = ScenePerception(PerceptionConfig(), tabletop)
    frames = [
        tabletop.frame(
            [tabletop.track('base', stamp_ns=STAMP_NS + k * SEC // 5, offset=(0.001 * k, 0, 0))],
            stamp_ns=STAMP_NS + k * SEC // 5,
        )
        for k in range(8)
    ]
    runs = [[perception.step(frame) for frame in frames] for _ in range(2)]
    for first, second in zip(*runs, strict=True):
        assert first.rejected == second.rejected == {}
        assert first.table_height == second.table_height
        np.testing.assert_array_equal(
            first.objects['base'].world_points, second.objects['base'].world_points
        )
        assert first.objects['base'].support == second.objects['base'].support


def test_support_of_unorganised_clouds_is_not_checked(tabletop):
    cloud = PointCloud(tabletop.cloud.points)
    result = step(tabletop, tabletop.frame(cloud=cloud))
    assert set(result.objects) == {'base', 'tall', 'top'}
    assert all(math.isnan(item.support) for item in result.objects.values())
    observed = step(tabletop, tabletop.frame(cloud=cloud), models=False)
    assert set(observed.objects) == {'base', 'tall', 'top'}


def test_works_without_tracks_and_with_a_camera_given_as_parameter(tabletop):
    perception = ScenePerception()
    perception.add_transform(tabletop.camera_transform())
    result = perception.step(tabletop.frame([], transforms=()))
    assert (result.objects, result.rejected, result.problem) == ({}, {}, None)


def test_absurd_tracks_do_not_raise(tabletop):
    far = dataclasses.replace(
        tabletop.track('base'), frame_from_object=Pose(np.array([1e200, -1e200, 1e200]))
    )
    result = step(tabletop, tabletop.frame([far, tabletop.track('tall')]))
    assert 'tall' in result.objects


@pytest.mark.parametrize(
    'wrong',
    [{'world_frame': ''}, {'max_range': 0.0}, {'thin_stride': 0}],
)
def test_refuses_impossible_settings(wrong):
    with pytest.raises(ConfigError):
        PerceptionConfig(**wrong)
