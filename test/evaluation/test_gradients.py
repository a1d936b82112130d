"""The comparison of gradients: its parts on small scenes, and the report."""

import dataclasses
import json

import numpy as np
import pytest
import torch

from spatial_relations_ros.core import ConfigError, Pose
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.evaluation.gradient_agreement import (
    MotionDistance,
    agreement,
    analytic_slopes,
    finite_differences,
)
from spatial_relations_ros.evaluation.gradient_cases import VARIANTS, displace
from spatial_relations_ros.evaluation.gradient_descents import PoseError, descend
from spatial_relations_ros.evaluation.gradients import compare_gradients, markdown
from spatial_relations_ros.learning import load_metric


@pytest.fixture(scope='module')
def metric():
    return load_metric()


@pytest.fixture
def case(relation_scenes):
    scene = relation_scenes.scene_of(relation_scenes.scenes[1])
    return displace(scene, np.random.default_rng(2))


def test_displacements_lie_within_their_bounds(relation_scenes):
    scene = relation_scenes.scene_of(relation_scenes.scenes[0])
    rng = np.random.default_rng(0)
    for _ in range(20):
        case = displace(scene, rng)
        before, after = case.reference.relative, case.scene.relative
        shift = np.linalg.norm(after.world_points.mean(0) - before.world_points.mean(0))
        assert 0.099 <= shift / case.extent <= 0.301
        turn = after.world_from_object.rotation @ before.world_from_object.rotation.T
        angle = np.degrees(np.arccos(0.5 * (np.trace(turn) - 1.0)))
        assert 9.9 <= angle <= 40.1
        assert case.scene.base.world_from_object == case.reference.base.world_from_object


def test_the_error_is_zero_where_the_object_was_whatever_the_heading(case):
    relative = case.reference.relative
    pose, moved = relative.world_from_object, case.scene.relative.world_from_object
    middle = case.scene.relative.world_points.astype(float).mean(axis=0)

    def motion_to(target):
        turn = target.rotation @ moved.rotation.T
        shift = target.translation - middle + turn @ (middle - moved.translation)
        angle = np.arccos(0.5 * (np.trace(turn) - 1.0))
        skew = (turn - turn.T) / (2.0 * np.sin(angle))
        axis = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
        return torch.from_numpy(np.concatenate([shift / case.extent, angle * axis])).float()

    error_of = PoseError(case)
    assert error_of(torch.zeros(6)) > 0.04
    assert error_of(motion_to(pose)) < 0.01
    # The base is square: after a quarter of a turn about it, or less with a worse fit of the
    # base, the pair stands as before.
    pivot = case.reference.base.world_points.mean(axis=0, dtype=np.float64)
    turn = matrix_from_rotvec(np.array([0.0, 0.0, np.radians(20.0)]))
    turned = Pose.from_rotation(turn @ pose.rotation, turn @ (pose.translation - pivot) + pivot)
    away = Pose(pose.translation + 0.2 * case.extent * np.array([0.0, 0.0, 1.0]), pose.quat_wxyz)
    assert error_of(motion_to(turned)) < 0.06 < error_of(motion_to(away))


def test_the_distance_of_a_motion_is_zero_without_a_displacement(metric, case):
    at_rest = dataclasses.replace(case, scene=case.reference)
    assert float(MotionDistance(metric, at_rest)(torch.zeros(6))) < 1e-3
    assert float(MotionDistance(metric, case)(torch.zeros(6))) > 0.01


def test_perfect_slopes_agree_perfectly(metric, case):
    slopes = finite_differences(MotionDistance(metric, case))
    assert np.linalg.norm(slopes) > 0.1
    result = agreement([slopes, 2.0 * slopes], [slopes, 2.0 * slopes])
    assert result['shift']['correlation'] == pytest.approx(1.0)
    assert result['turn']['equal_sign'] == 1.0
    opposite = agreement([slopes, 2.0 * slopes], [-slopes, -2.0 * slopes])
    assert opposite['shift']['correlation'] == pytest.approx(-1.0)
    assert opposite['turn']['equal_sign'] == 0.0


@pytest.mark.parametrize('variant', VARIANTS, ids=lambda variant: variant.name)
def test_every_gradient_descends_and_leaves_the_metric_as_it_was(metric, case, variant):
    projection = metric.encoder.projection
    assert np.isfinite(analytic_slopes(metric, case, variant)).all()
    descent = descend(metric, case, variant, steps=16)
    assert descent.distances[1] < 0.9 * descent.distances[0]
    assert metric.encoder.projection == projection


def test_the_report_counts_every_case(metric, relation_scenes):
    report = compare_gradients(
        metric, relation_scenes, num_cases=3, seed=0, variants=VARIANTS[:2], steps=8
    )
    assert list(report) == ['silhouette', 'sobel']
    for row in report.values():
        outcome = row['outcome']
        assert outcome['cases'] == len(outcome['descents']) == 3
        low, high = outcome['wilson_95']
        assert low <= outcome['back'] / 3 <= high
    assert report['silhouette']['outcome']['only_this'] == 0
    assert markdown(json.loads(json.dumps(report))).count('\n') == 3


def test_more_cases_than_scenes_are_refused(metric, relation_scenes):
    with pytest.raises(ConfigError, match='2 to 16'):
        compare_gradients(metric, relation_scenes, num_cases=17, seed=0)
