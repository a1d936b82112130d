"""What targets mean for a robot: obstacles, reach, ways in, gripper and order together."""

import dataclasses

import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError, Pose, Scene
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.imitation import ArmReach, ImitationOptions, Move, Obstacle, imitate
from spatial_relations_ros.imitation.placing import Placing
from spatial_relations_ros.imitation.shape import shape_of
from spatial_relations_ros.learning import load_metric

ON_TRAY = np.array([0.0, 0.0, 0.1302])


@pytest.fixture(scope='module')
def apart(solids):
    return Scene(
        solids.box('tray', (0.3, 0.2, 0.04), (0, 0, 0.02)),
        solids.box('carton', (0.07, 0.07, 0.18), (0.35, 0.05, 0.09)),
    )


def placed(scene, target, movable=(False, True), **options):
    shapes = tuple(shape_of(item) for item in scene.objects)
    placing = Placing(scene, shapes, movable, 0.0, ImitationOptions(**options))
    return placing.at((scene.base.world_from_object, target))


def test_a_target_without_anything_in_the_way(apart):
    result = placed(apart, Pose(ON_TRAY))
    tray, carton = result.placements
    assert result.violations == ()
    assert result.order == (Move('carton'),)
    np.testing.assert_allclose(carton.approach.translation, ON_TRAY + [0, 0, 0.1])
    assert carton.approach_clear
    assert carton.reachable
    assert carton.gripper_target is None
    assert tray.approach_clear


def test_what_stays_needs_no_move(apart):
    result = placed(apart, apart.relative.world_from_object)
    assert result.order == ()
    assert result.violations == ()


def test_an_obstacle_is_told_and_counts_as_penetration(apart, solids):
    jar = solids.box('jar', (0.1, 0.1, 0.2), (0.075, 0, 0.14))
    result = placed(apart, Pose(ON_TRAY), obstacles=(Obstacle.of_object(jar),))
    assert 'carton would overlap jar by 10 mm' in result.violations
    assert result.placements[1].penetration == pytest.approx(0.01, abs=1e-3)
    # What does not move may touch: it stands there already.
    beside = solids.box('jar', (0.1, 0.1, 0.2), (0.19, 0, 0.1))
    assert placed(apart, Pose(ON_TRAY), obstacles=(Obstacle.of_object(beside),)).violations == ()


def test_out_of_reach_is_told_of_each_place(apart):
    arm = ArmReach(np.array([[0.0, -0.6, 0.4]]))
    near = placed(apart, Pose(ON_TRAY), arm=arm)
    assert near.violations == ()
    assert near.placements[1].reachable
    far = ArmReach(np.array([[-0.7, 0.0, 0.1302]]))
    result = placed(apart, Pose(ON_TRAY), arm=far)
    assert result.violations == (
        'carton is now 1.05 m from the nearest shoulder (reach 0.25 to 0.85 m)',
    )
    assert not result.placements[1].reachable
    # The tray is not to be moved: nobody needs to reach it.
    assert placed(apart, apart.relative.world_from_object, arm=far).violations == ()


def test_a_grasp_gives_where_the_gripper_goes(apart):
    grasp = Pose.from_rotation(matrix_from_rotvec(np.array([0, np.pi / 2, 0])), [0, 0, 0.15])
    turned = Pose.from_rotation(matrix_from_rotvec(np.array([0, 0, 1.0])), ON_TRAY)
    carton = placed(apart, turned, grasps={'carton': grasp}).placements[1]
    held = carton.gripper_target.inverse() @ carton.target
    assert held.is_close(grasp.inverse())
    np.testing.assert_allclose(carton.gripper_target.translation, ON_TRAY + [0, 0, 0.15])
    rise = carton.gripper_approach.translation - carton.gripper_target.translation
    np.testing.assert_allclose(rise, [0, 0, 0.1], atol=1e-9)
    # Reach is that of the gripper: 0.15 m above the middle.
    low = ArmReach(np.array([[0.0, -0.6, 0.1302]]), 0.1, 0.65)
    assert placed(apart, Pose(ON_TRAY), arm=low).violations != ()
    assert placed(apart, Pose(ON_TRAY), arm=low, grasps={'carton': grasp}).violations != (
        placed(apart, Pose(ON_TRAY), arm=low).violations
    )


@pytest.mark.filterwarnings('error::RuntimeWarning')  # the cavity has no opening
def test_a_blocked_way_is_told(solids):
    from manifold3d import Manifold

    outer = Manifold.cube((0.2, 0.2, 0.2), True)
    box = solids.of('box', outer - Manifold.cube((0.1, 0.1, 0.1), True), (0, 0, 0.1))
    scene = Scene(box, solids.box('die', (0.03, 0.03, 0.03), (0.5, 0, 0.015)))
    result = placed(scene, Pose(np.array([0.0, 0.0, 0.0652])))
    assert 'die could not be brought there: no straight way of 0.10 m is free' in result.violations
    assert not result.placements[1].approach_clear


def test_answers_keep_clear_of_obstacles(apart, solids):
    metric = load_metric()
    demonstration = Scene(
        solids.box('plate', (0.22, 0.2, 0.03), (0.4, 0.1, 0.015)),
        solids.cup('cup', 0.04, 0.1, (0.41, 0.1, 0.0805)),
    )
    jar = solids.box('jar', (0.12, 0.3, 0.2), (-0.1, 0, 0.1405))
    options = ImitationOptions(obstacles=(Obstacle.of_object(jar),), seed=1)
    best = imitate(metric, demonstration, apart, options).answers[0]
    assert best.feasible, best.violations
    # The jar occupies the tray's left part.
    assert best.scene(apart).relative.world_points[:, 0].min() > -0.045
    everywhere = dataclasses.replace(
        options, obstacles=(Obstacle.of_object(solids.box('lid', (2, 2, 0.3), (0, 0, 0.2))),)
    )
    assert not imitate(metric, demonstration, apart, everywhere).success


@pytest.mark.parametrize('height', [-0.1, np.nan, np.inf])
def test_impossible_approaches_are_refused(height):
    with pytest.raises(ConfigError, match='approach_height'):
        ImitationOptions(approach_height=height)
