from pathlib import Path

import numpy as np
import pytest

from spatial_relations_ros.cli.pose_files import read_pose_file
from spatial_relations_ros.core import Pose, Scene, SceneObject
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.datasets.object_files import load_object_model
from spatial_relations_ros.datasets.objects import sample_object
from spatial_relations_ros.imitation import ImitationOptions, imitate
from spatial_relations_ros.imitation.lean import turned_over
from spatial_relations_ros.imitation.shape import shape_of
from spatial_relations_ros.imitation.solids import solid_of
from spatial_relations_ros.imitation.statics import rests

REPOSITORY = Path(__file__).resolve().parents[2]


def turned(item, rotvec):
    rotation = matrix_from_rotvec(np.array(rotvec, float))
    return item.moved_to(Pose.from_rotation(rotation, item.world_from_object.translation))


def placed(item):
    return solid_of(shape_of(item), 1.0).placed(item.world_from_object, (0.0, 0.0, 0.0))


def scene_object(object_id, path, world_from_object):
    mesh, points = load_object_model(path)
    return SceneObject(object_id, points, world_from_object, mesh=mesh)


def standing(object_id, mesh, where):
    points = mesh.sample_surface(4096, np.random.default_rng(0))
    pose = Pose((where, 0.0, -float(mesh.vertices[:, 2].min())))
    return SceneObject(object_id, points, pose, mesh=mesh)


@pytest.fixture(scope='module')
def carton(solids):
    return solids.box('carton', (0.05, 0.07, 0.16), (0.3, 0, 0.08))


def test_turning_over_counts_and_turning_about_the_vertical_does_not(carton):
    now = carton.world_from_object.rotation
    for rotvec, share in (((0, 0, 2.0), 0.0), ((np.pi / 2, 0, 0), 0.5), ((np.pi, 0, 0), 1.0)):
        after = turned(carton, rotvec).world_from_object.rotation
        assert turned_over(now, after) == pytest.approx(share, abs=1e-6)


def test_a_mug_is_not_put_upside_down_without_need(metric, solids):
    demonstration = Scene(
        solids.cup('pot', 0.09, 0.12, (0, 0, 0.06)),
        solids.box('can', (0.06, 0.06, 0.11), (0, 0, 0.0592)),
    )
    test = Scene(
        solids.cup('bucket', 0.1, 0.12, (0, 0, 0.06)),
        solids.cup('mug', 0.035, 0.09, (0.4, 0, 0.045)),
    )
    result = imitate(metric, demonstration, test, ImitationOptions())
    assert result.success, result.message
    up = result.answers[0].placements[1].target.rotation[2, 2]
    assert up > 0.99


def test_a_mug_is_not_laid_on_its_side_because_that_looks_more_like_a_squat_cup(metric):
    """The tutorial's objects: lying, the mug is half as far from the demonstration."""
    plate_pose, cup_pose = read_pose_file(REPOSITORY / 'examples/cup_on_plate.json')
    demonstration = Scene(
        scene_object('plate', REPOSITORY / 'bags/objects' / 'plate.ply', plate_pose),
        scene_object('cup', REPOSITORY / 'bags/objects' / 'cup.ply', cup_pose),
    )
    rng = np.random.default_rng(4)
    tray, mug = (sample_object(family, rng).mesh for family in ('tray', 'mug'))
    test = Scene(standing('tray', tray, 0.0), standing('mug', mug, 0.3))
    result = imitate(metric, demonstration, test, ImitationOptions())
    assert result.success, result.message
    assert result.answers[0].placements[1].target.rotation[2, 2] > 0.99


def test_what_stays_on_a_tilted_table_does_not_on_one_tilted_more(solids):
    base = placed(solids.box('base', (0.3, 0.3, 0.05), (0, 0, 0.025)))
    tower = placed(solids.box('tower', (0.03, 0.03, 0.3), (0, 0, 0.2)))
    # It tips at atan(15 / 150), 5.7 degrees.
    assert rests(tower, base)
    assert not rests(tower, base, tilt_rad=np.deg2rad(8.0))
