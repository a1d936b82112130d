"""Imitation with the weights that ship."""

import dataclasses

import numpy as np
import pytest

from spatial_relations_ros.core import (
    ConfigError,
    ImitationError,
    Pose,
    Scene,
    SceneObject,
)
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.imitation import ImitationOptions, imitate
from spatial_relations_ros.imitation.objective_setup import make_objective
from spatial_relations_ros.imitation.poses import pose_tensors

QUICK = ImitationOptions(num_starts=2, max_steps=12)


def test_the_demonstrated_relation_is_reproduced_with_other_objects(metric, on_top, apart):
    result = imitate(metric, on_top, apart, QUICK)
    assert result.success, result.message
    best = result.answers[0]
    assert best.feasible
    assert best.distance < 0.5 * result.initial_distance
    carton = best.scene(apart).relative.world_points
    tray = best.scene(apart).base.world_points
    assert carton[:, 2].min() == pytest.approx(tray[:, 2].max(), abs=5e-3)
    middle = carton.mean(axis=0)
    assert (tray.min(axis=0)[:2] < middle[:2]).all()
    assert (middle[:2] < tray.max(axis=0)[:2]).all()


def test_an_object_that_may_not_move_stays(metric, on_top, apart):
    result = imitate(metric, on_top, apart, QUICK)
    base, relative = result.answers[0].placements
    np.testing.assert_array_equal(base.target.as_matrix(), base.current.as_matrix())
    assert not relative.target.is_close(relative.current, metres=0.05)
    approach = relative.approach.translation - relative.target.translation
    np.testing.assert_allclose(approach, [0, 0, QUICK.approach_height], atol=1e-9)


def test_a_scene_that_imitates_itself_is_kept(metric, on_top):
    result = imitate(metric, on_top, on_top, QUICK)
    assert result.success
    assert result.initial_distance < 1e-3
    placement = result.answers[0].placements[1]
    assert placement.target.is_close(placement.current, metres=5e-3, angle_rad=0.05)


def displaced(scene, shift, rotvec):
    pose = scene.relative.world_from_object
    turn = matrix_from_rotvec(np.array(rotvec, float))
    moved = Pose.from_rotation(turn @ pose.rotation, pose.translation + np.array(shift))
    return scene.with_poses(scene.base.world_from_object, moved)


@pytest.mark.parametrize(
    ('shift', 'rotvec'), [((0, 0, 0.03), (0, 0, 0)), ((0.05, 0.03, 0.02), (0, 0.2, 0))]
)
def test_a_displaced_copy_converges_back_through_the_metric_alone(metric, on_top, shift, rotvec):
    test = displaced(on_top, shift, rotvec)
    options = ImitationOptions(
        propose=False, num_starts=1, max_steps=60, physics_weight=0.0, learning_rate=0.01
    )
    result = imitate(metric, on_top, test, options)
    after = result.answers[0].placements[1].target.translation
    goal = on_top.relative.world_from_object.translation
    start = test.relative.world_from_object.translation
    assert result.answers[0].distance < 0.5 * result.initial_distance
    assert abs(after - goal)[2] < 0.5 * abs(start - goal)[2]


def test_the_distance_history_begins_with_the_scene_as_it_stands(metric, on_top, apart):
    result = imitate(metric, on_top, apart, QUICK)
    assert result.distance_history[0] == pytest.approx(result.initial_distance)
    assert result.num_steps == QUICK.max_steps
    assert len(result.distance_history) > QUICK.max_steps + 2  # before, proposals, each step
    assert (np.diff(result.distance_history) <= 0.0).all()  # of the nearest so far
    assert result.duration_sec > 0.0


def test_the_same_seed_gives_the_same_answer(metric, on_top, apart):
    first, second = (imitate(metric, on_top, apart, QUICK) for _ in range(2))
    for a, b in zip(first.answers[0].placements, second.answers[0].placements, strict=True):
        np.testing.assert_array_equal(a.target.as_matrix(), b.target.as_matrix())


def test_several_answers_are_distinct_and_ranked(metric, on_top, apart):
    options = dataclasses.replace(QUICK, num_starts=6, max_steps=4, num_answers=4)
    answers = imitate(metric, on_top, apart, options).answers
    assert 1 < len(answers) <= 4
    similar = 0.5 if metric.calibration is None else metric.calibration.same_relation_distance
    keys = [
        (
            not (answer.feasible and answer.distance < similar),
            not answer.alike,
            answer.distance + answer.handicap,
        )
        for answer in answers
    ]
    assert keys == sorted(keys)
    # The scene as it stands and attempts that failed are no alternatives.
    assert not any(failed for failed, *_ in keys[1:])
    for i, first in enumerate(answers):
        for second in answers[i + 1 :]:
            a, b = first.placements[1].target, second.placements[1].target
            assert not a.is_close(b, metres=0.01, angle_rad=0.1)


def test_cancelling_returns_the_best_answer_so_far(metric, on_top, apart):
    steps, seen = [], []

    def stop_at_three(progress):
        steps.append(progress.step)
        seen.append(progress.best)
        assert progress.best.placements[1].object_id == 'carton'
        return progress.step < 3

    result = imitate(metric, on_top, apart, QUICK, on_progress=stop_at_three)
    assert result.cancelled
    assert 'cancelled' in result.message
    assert steps == sorted(steps)
    assert steps[-4:] == [0, 1, 2, 3]
    # At least as good as what was told last, and finished: it rests somewhere.
    assert result.answers[0].distance <= seen[-1].distance
    assert result.answers[0].feasible


def test_progress_tells_of_the_best_answer_so_far(metric, on_top, apart):
    seen = []

    def watch(progress):
        assert progress.distance == progress.best.distance
        assert progress.feasible == progress.best.feasible
        seen.append(progress.best)
        return True

    result = imitate(metric, on_top, apart, QUICK, on_progress=watch)
    # The first report is the scene as it stands.
    assert seen[0].distance == pytest.approx(result.initial_distance)
    assert seen[-1].distance < seen[0].distance
    assert result.answers[0].distance <= seen[-1].distance


def test_cancelling_at_once_still_answers(metric, on_top, apart):
    result = imitate(metric, on_top, apart, QUICK, on_progress=lambda progress: False)
    assert result.cancelled
    assert result.num_steps == 0
    assert result.answers


def test_a_tiny_budget_gives_the_best_proposal(metric, on_top, apart):
    options = dataclasses.replace(QUICK, time_budget_sec=0.01)
    result = imitate(metric, on_top, apart, options)
    assert result.num_steps == 0
    assert result.answers[0].distance <= result.initial_distance


@pytest.mark.parametrize('movable', [('base',), ('base', 'relative')])
def test_the_base_may_move_too(metric, on_top, apart, movable):
    result = imitate(metric, on_top, apart, dataclasses.replace(QUICK, movable=movable))
    base, relative = result.answers[0].placements
    assert result.answers[0].distance <= result.initial_distance
    if movable == ('base',):
        assert relative.target.is_close(relative.current, metres=1e-5, angle_rad=1e-3)
        assert not base.target.is_close(base.current, metres=0.01)


def test_the_papers_optimisation_lowers_the_distance(metric, on_top, apart):
    options = dataclasses.replace(ImitationOptions.paper(), max_steps=15, learning_rate=0.02)
    result = imitate(metric, on_top, apart, options)
    assert result.answers[0].distance < result.initial_distance


def test_a_scene_far_from_the_worlds_origin_is_imitated_alike(metric, on_top, apart):
    shift = np.array([4e5, -3e5, 20.0])

    def moved(item):
        pose = item.world_from_object
        return dataclasses.replace(pose, translation=pose.translation + shift)

    far = apart.with_poses(*(moved(item) for item in apart.objects))
    near_answer = imitate(metric, on_top, apart, QUICK).answers[0].placements[1].target
    far_answer = imitate(metric, on_top, far, QUICK).answers[0].placements[1].target
    back = dataclasses.replace(far_answer, translation=far_answer.translation - shift)
    assert back.is_close(near_answer, metres=0.01, angle_rad=0.05)


def test_keeping_the_heading_puts_it_on_the_demonstrated_side(metric, solids, apart):
    box = solids.box('left', (0.1, 0.1, 0.1), (0, 0, 0.05))
    demonstration = Scene(box, solids.box('right', (0.1, 0.1, 0.1), (0, -0.16, 0.05)))
    options = dataclasses.replace(QUICK, keep_heading=True)
    placements = imitate(metric, demonstration, apart, options).answers[0].placements
    offset = placements[1].target.translation - placements[0].target.translation
    assert offset[1] < -0.05
    assert abs(offset[0]) < abs(offset[1])


def test_the_heading_does_not_depend_on_where_a_mesh_has_its_origin(metric, on_top, apart):
    def penalty(scene):
        options = ImitationOptions(keep_heading=True)
        objective = make_objective(metric, beside, scene, options)
        poses = tuple(item.world_from_object for item in scene.objects)
        return float(objective.heading_penalty(*pose_tensors([poses], objective.origin))[0])

    beside = apart
    turned = Pose.from_rotation(matrix_from_rotvec(np.array([0.0, 0.0, 0.8])), (0.1, 0.3, 0.02))
    scene = apart.with_poses(turned, apart.relative.world_from_object)
    assert penalty(scene) > 0.1
    shift = np.array([0.0, 0.3, 0.0])
    base = dataclasses.replace(
        scene.base,
        points=(scene.base.points + shift).astype(np.float32),
        mesh=None,
        world_from_object=Pose(turned.apply(-shift), turned.quat_wxyz),
    )
    plain = dataclasses.replace(scene.base, mesh=None)
    assert penalty(Scene(base, scene.relative)) == pytest.approx(
        penalty(Scene(plain, scene.relative)), abs=1e-3
    )


def test_clouds_without_meshes_are_imitated_too(metric, on_top, apart):
    clouds = [dataclasses.replace(item, mesh=None) for item in apart.objects]
    result = imitate(metric, on_top, Scene(*clouds), QUICK)
    assert result.answers[0].distance < result.initial_distance


def test_objects_in_millimetres_are_refused_with_their_size(metric, on_top, solids):
    huge = Scene(
        solids.box('tray', (3e3, 2e3, 40.0), (0, 0, 0)),
        solids.box('carton', (70.0, 70.0, 180.0), (4e3, 0, 0)),
    )
    with pytest.raises(ImitationError, match='must be in metres'):
        imitate(metric, on_top, huge, QUICK)


@pytest.mark.parametrize('size', [0.01, 2.0])
def test_tiny_and_huge_references_are_fine(metric, on_top, apart, size):
    def scaled(item):
        factor = size / 0.22
        points = item.points * factor
        pose = Pose(item.world_from_object.translation * factor)
        return SceneObject(item.object_id, points, pose)

    reference = Scene(*(scaled(item) for item in on_top.objects))
    assert metric.distance(reference, on_top) < 0.2
    assert imitate(metric, reference, apart, QUICK).answers[0].feasible


@pytest.mark.parametrize(
    'settings',
    [
        {'movable': ()},
        {'movable': ('cup',)},
        {'num_answers': 0},
        {'num_starts': 0},
        {'time_budget_sec': -1.0},
        {'time_budget_sec': float('nan')},
        {'learning_rate': 0.0},
        {'learning_rate_spread': 0.5},
        {'table_height': float('inf')},
    ],
)
def test_impossible_options_are_refused(settings):
    with pytest.raises(ConfigError):
        ImitationOptions(**settings)
