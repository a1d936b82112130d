"""Imitation that begins with an earlier answer, and what counts as a change of a relation."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from spatial_relations_ros.core import Pose
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.imitation import ImitationOptions, imitate
from spatial_relations_ros.imitation.relation_change import relation_change

QUICK = ImitationOptions(num_starts=1, max_steps=6, num_proposals=32)


def targets(result):
    base, relative = (placement.target for placement in result.answers[0].placements)
    return base, relative


def moved(scene, shift=(0, 0, 0), rotvec=(0, 0, 0)):
    pose = scene.relative.world_from_object
    turn = matrix_from_rotvec(np.array(rotvec, float))
    relative = Pose.from_rotation(turn @ pose.rotation, pose.translation + np.array(shift))
    return scene.with_poses(scene.base.world_from_object, relative)


def test_the_answer_to_a_small_change_stays_near_the_last_one(metric, on_top, apart):
    first = imitate(metric, on_top, apart, QUICK)
    assert first.success
    changed = moved(on_top, (0.012, 0.0, 0.0))
    start = targets(first)
    again = imitate(metric, changed, apart, dataclasses.replace(QUICK, start=start))
    assert again.success
    assert targets(again)[1].is_close(start[1], metres=0.04, angle_rad=0.4)
    # Only what lies near it was looked at: a fraction of the evaluations.
    assert len(again.distance_history) < len(first.distance_history)


def test_a_start_that_is_another_relation_does_not_stand_in_the_way(metric, on_top, apart):
    beside = apart.base.world_from_object, apart.relative.world_from_object
    result = imitate(metric, on_top, apart, dataclasses.replace(QUICK, start=beside))
    assert result.success
    tray, carton = (item.world_points for item in result.answers[0].scene(apart).objects)
    assert carton[:, 2].min() == pytest.approx(tray[:, 2].max(), abs=5e-3)


def test_moving_or_turning_both_together_changes_no_relation(on_top):
    turn = Pose.from_rotation(matrix_from_rotvec(np.array([0.0, 0.0, 1.0])), [0.3, -0.2, 0.1])
    together = on_top.with_poses(*(turn @ item.world_from_object for item in on_top.objects))
    change = relation_change(on_top, together)
    assert change.metres == pytest.approx(0.0, abs=1e-9)
    assert change.angle_rad == pytest.approx(0.0, abs=1e-6)
    assert not change.exceeds(0.001, 0.001)


def test_what_moves_turns_or_tilts_changes_it(on_top):
    assert relation_change(on_top, moved(on_top, (0.02, 0, 0))).metres == pytest.approx(0.02)
    turned = relation_change(on_top, moved(on_top, rotvec=(0, 0, 0.3)))
    assert turned.angle_rad == pytest.approx(0.3)
    tilt = Pose.from_rotation(matrix_from_rotvec(np.array([0.2, 0.0, 0.0])), [0, 0, 0])
    tilted = on_top.with_poses(*(tilt @ item.world_from_object for item in on_top.objects))
    change = relation_change(on_top, tilted)
    assert change.angle_rad == pytest.approx(0.2)
    assert change.exceeds(0.01, 0.1)
