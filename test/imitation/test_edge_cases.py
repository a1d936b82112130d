"""Requests at the border of what can be imitated: a right answer, or a clear refusal."""

import dataclasses

import numpy as np
import pytest
import torch
from manifold3d import Manifold

from spatial_relations_ros.core import (
    ImitationError,
    InvalidPoseError,
    InvalidSceneError,
    Pose,
    Scene,
    SceneObject,
    TriangleMesh,
)
from spatial_relations_ros.imitation import ImitationOptions, imitate
from spatial_relations_ros.imitation.manipulation import Obstacle


@pytest.fixture(scope='module')
def inside(solids):
    return Scene(
        solids.cup('pot', 0.09, 0.14, (0.0, 0.0, 0.07)),
        solids.box('carton', (0.05, 0.05, 0.12), (0.01, 0.0, 0.0642)),
    )


def test_with_swapped_objects_the_roles_are_swapped(metric, on_top, solids):
    swapped = Scene(
        solids.box('carton', (0.14, 0.12, 0.18), (0.0, 0.0, 0.09)),
        solids.box('tray', (0.2, 0.16, 0.03), (0.4, 0.0, 0.015)),
    )
    result = imitate(metric, on_top, swapped)
    assert result.success, result.message
    scene = result.answers[0].scene(swapped)
    assert scene.relative.world_points[:, 2].min() > scene.base.world_points[:, 2].max() - 5e-3


def test_two_identical_objects_are_stacked(metric, on_top, solids):
    first = solids.box('block', (0.1, 0.1, 0.06), (0.0, 0.0, 0.03))
    twins = Scene(
        first,
        dataclasses.replace(first, object_id='twin').moved_to(Pose(np.array([0.3, 0, 0.03]))),
    )
    result = imitate(metric, on_top, twins)
    assert result.answers[0].feasible
    assert result.answers[0].distance < result.initial_distance


def test_a_base_that_stands_on_the_relative_is_not_left_in_the_air(metric, on_top, solids):
    stack = Scene(
        solids.box('tray', (0.2, 0.16, 0.03), (0.0, 0.0, 0.136)),
        solids.box('can', (0.07, 0.07, 0.12), (0.0, 0.0, 0.06)),
    )
    alone = imitate(metric, on_top, stack, ImitationOptions())
    assert not alone.success
    assert 'tray stands on can and would fall' in ' '.join(alone.answers[0].violations)
    both = imitate(metric, on_top, stack, ImitationOptions(movable=('base', 'relative')))
    assert both.success, both.message


def test_an_object_that_is_kept_upright_does_not_tip(metric, on_top, solids):
    corners = np.array([(x, y) for x in (-0.12, 0.12) for y in (-0.1, 0.1)])
    slope = Manifold.hull_points(
        np.array([(x, y, z) for x, y in corners for z in (0.0, 0.05 + 0.1 * x)])
    )
    test = Scene(
        solids.of('wedge', slope, (0.0, 0.0, 0.0)),
        solids.box('carton', (0.08, 0.08, 0.1), (0.4, 0.0, 0.05)),
    )

    def tilts(options):
        answers = imitate(metric, on_top, test, options).answers
        ups = [answer.placements[1].target.rotation[2, 2] for answer in answers]
        return np.degrees(np.arccos(np.clip(ups, -1.0, 1.0)))

    assert tilts(ImitationOptions(num_answers=3)).max() > 4.0, 'it tips onto the slope'
    assert tilts(ImitationOptions(num_answers=3, keep_upright=True)).max() < 0.1


@pytest.mark.filterwarnings('error::RuntimeWarning')
@pytest.mark.parametrize('above', [0.01, 0.5])
def test_a_table_above_the_base_is_no_trouble(metric, on_top, apart, above):
    top = float(apart.base.world_points[:, 2].max())
    result = imitate(metric, on_top, apart, ImitationOptions(table_height=top + above))
    assert result.message


def test_a_mug_of_a_millimetre_is_answered(metric, on_top, solids):
    test = Scene(
        solids.box('tray', (0.3, 0.2, 0.04), (0.0, 0.0, 0.02)),
        solids.cup('mug', 0.0005, 0.0012, (0.2, 0.0, 0.0006), wall=0.00005),
    )
    result = imitate(metric, on_top, test)
    assert result.message


def test_a_mesh_with_a_hole_is_imitated_as_the_solid_of_its_cloud(metric, on_top, apart):
    whole = apart.relative.mesh
    torn = TriangleMesh(whole.vertices, whole.triangles[1:])
    points = whole.sample_surface(8192, np.random.default_rng(0))
    test = Scene(apart.base, dataclasses.replace(apart.relative, points=points, mesh=torn))
    result = imitate(metric, on_top, test)
    assert result.success, result.message
    scene = result.answers[0].scene(test)
    gap = scene.relative.world_points[:, 2].min() - scene.base.world_points[:, 2].max()
    assert abs(gap) < 4e-3


def test_millimetres_taken_for_metres_are_refused(metric, on_top, apart):
    large = dataclasses.replace(apart.base, points=apart.base.points * np.float32(1e4), mesh=None)
    with pytest.raises(ImitationError, match='must be in metres'):
        imitate(metric, on_top, Scene(large, apart.relative))


def test_an_obstacle_where_it_would_go_is_kept_clear_of(metric, on_top, apart, solids):
    free = imitate(metric, on_top, apart).answers[0]
    taken = free.placements[1].target.translation
    post = solids.box('post', (0.02, 0.02, 0.6), (taken[0], taken[1], 0.4))
    options = ImitationOptions(obstacles=(Obstacle.of_object(post),))
    answer = imitate(metric, on_top, apart, options).answers[0]
    assert answer.feasible, answer.violations
    carton = answer.scene(apart).relative.world_points
    assert np.abs(carton[:, :2] - taken[:2]).max(axis=1).min() > 0.01 - 5e-3


def test_a_plate_into_a_mug_is_refused_with_the_nearest_attempt(metric, inside, solids):
    impossible = Scene(
        solids.cup('mug', 0.04, 0.1, (0.0, 0.0, 0.05)),
        solids.box('plate', (0.24, 0.24, 0.02), (0.4, 0.0, 0.01)),
    )
    result = imitate(metric, inside, impossible)
    assert not result.success
    assert 'no placement was found' in result.message or 'no feasible' in result.message
    assert result.answers
    assert not (result.answers[0].feasible and result.answers[0].distance < 0.5)


@pytest.mark.parametrize('size', [0.01, 2.0])
def test_tiny_and_huge_objects_are_placed_too(metric, on_top, apart, size):
    factor = size / 0.3

    def scaled(item):
        mesh = TriangleMesh((item.mesh.vertices * factor).astype(np.float32), item.mesh.triangles)
        pose = Pose(item.world_from_object.translation * factor, item.world_from_object.quat_wxyz)
        return dataclasses.replace(
            item, points=item.points * np.float32(factor), mesh=mesh, world_from_object=pose
        )

    test = Scene(*(scaled(item) for item in apart.objects))
    result = imitate(metric, on_top, test)
    assert result.success, result.message
    scene = result.answers[0].scene(test)
    gap = scene.relative.world_points[:, 2].min() - scene.base.world_points[:, 2].max()
    assert abs(gap) < 0.02 * size


def test_ten_milliseconds_still_give_an_answer_with_its_faults(metric, on_top, apart):
    result = imitate(metric, on_top, apart, ImitationOptions(time_budget_sec=0.01))
    best = result.answers[0]
    assert best.feasible == (not best.violations)
    assert result.success == (best.feasible and result.message.startswith('distance'))
    assert result.success or result.message.startswith('the time budget of 0.01 s was too short')


def test_what_must_stay_on_the_table_is_not_put_on_anything(metric, on_top, apart):
    result = imitate(metric, on_top, apart, ImitationOptions(keep_on_table=True, max_steps=2))
    assert not result.success
    carton = result.answers[0].scene(apart).relative.world_points
    assert carton[:, 2].min() == pytest.approx(0.0, abs=3e-3)


def test_the_time_of_a_request_is_told_by_parts(metric, on_top, apart):
    result = imitate(metric, on_top, apart, ImitationOptions(max_steps=2))
    assert set(result.stage_seconds) == {
        'preparation', 'proposals', 'embedding', 'refinement', 'checks'
    }  # fmt: skip
    assert all(seconds > 0.0 for seconds in result.stage_seconds.values())
    assert sum(result.stage_seconds.values()) <= result.duration_sec


def test_a_stop_is_asked_for_before_each_proposal(metric, on_top, apart):
    asked = []

    def stop_at_the_fifth(progress):
        asked.append(progress.step)
        return len(asked) < 5

    result = imitate(metric, on_top, apart, on_progress=stop_at_the_fifth)
    assert result.cancelled
    # Fewer than the first eight, which are compared together.
    assert len(asked) == 5
    assert result.num_steps == 0


def test_the_same_seed_gives_the_same_bytes_and_another_thread_count_the_same_relation(
    metric, on_top, apart
):
    def targets():
        answer = imitate(metric, on_top, apart).answers[0]
        return answer, np.array([p.target.as_matrix() for p in answer.placements])

    threads = torch.get_num_threads()
    try:
        torch.set_num_threads(1)
        (first, one), (_, again) = targets(), targets()
        torch.set_num_threads(2)
        second, _ = targets()
    finally:
        torch.set_num_threads(threads)
    assert one.tobytes() == again.tobytes()
    # Sums in another order may choose another of several good placements.
    assert second.feasible
    assert second.distance == pytest.approx(first.distance, abs=0.05)


@pytest.mark.parametrize('count', [0, 1])
def test_clouds_without_extent_are_refused_by_name(count):
    with pytest.raises(InvalidSceneError, match='mug'):
        SceneObject('mug', np.zeros((count, 3), dtype=np.float32), Pose())


def test_a_pose_that_is_not_a_number_is_refused():
    with pytest.raises(InvalidPoseError, match='not finite'):
        Pose(np.array([0.0, np.nan, 0.0]))


def test_refined_through_soft_images_the_answer_is_measured_by_hard_ones(metric, on_top, apart):
    options = ImitationOptions(soft_refinement=True, max_steps=5)
    result = imitate(metric, on_top, apart, options)
    assert result.success, result.message
    assert result.num_steps == 5
    scene = result.answers[0].scene(apart)
    assert result.answers[0].distance == pytest.approx(metric.distance(on_top, scene), abs=1e-3)
    # The metric is as it was.
    assert metric.encoder.projection.gradient != 'soft'
