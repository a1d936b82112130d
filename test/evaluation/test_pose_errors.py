"""Datasets with the errors of a tracker."""

import numpy as np
import pytest

from spatial_relations_ros.evaluation.pose_errors import with_pose_errors


@pytest.fixture(scope='module')
def exact(relation_scenes):
    return relation_scenes


@pytest.fixture(scope='module')
def wrong(exact):
    return with_pose_errors(exact, 0.053, seed=0)


def test_as_many_degrees_as_upright_objects_of_human_made_scenes_are_tilted(exact, wrong):
    tilts = [
        np.degrees(np.arccos((before.rotation.T @ after.rotation)[2, 2]))
        for old, new in zip(exact.scenes, wrong.scenes, strict=True)
        for before, after in (
            (old.world_from_base, new.world_from_base),
            (old.world_from_relative, new.world_from_relative),
        )
    ]
    assert np.median(tilts) == pytest.approx(3.6, abs=0.6)


def test_objects_turn_about_their_middles_and_shift_by_less_than_a_few_hundredths(exact, wrong):
    for old, new in zip(exact.scenes, wrong.scenes, strict=True):
        before, after = exact.scene_of(old), wrong.scene_of(new)
        extent = np.ptp(np.concatenate([o.world_points for o in before.objects]), axis=0).max()
        for one, other in zip(before.objects, after.objects, strict=True):
            middle = 0.5 * (one.points.min(axis=0) + one.points.max(axis=0))
            moved = other.world_from_object.apply(middle) - one.world_from_object.apply(middle)
            assert 0.0 < np.linalg.norm(moved) < 0.05 * extent


def test_the_same_seed_errs_alike_and_labels_stay(exact, wrong):
    again, other = (with_pose_errors(exact, 0.053, seed=seed) for seed in (0, 1))
    assert [scene.label for scene in wrong.scenes] == [scene.label for scene in exact.scenes]
    turns = [
        [scene.world_from_base.quat_wxyz.tolist() for scene in dataset.scenes]
        for dataset in (wrong, again, other)
    ]
    assert turns[0] == turns[1]
    assert turns[0] != turns[2]
