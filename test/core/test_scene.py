import numpy as np
import pytest

from spatial_relations_ros.core import InvalidSceneError, Pose, Scene, SceneObject, TriangleMesh

TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32)
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.int32)


def test_world_points_are_the_posed_points():
    item = SceneObject('cup', TETRAHEDRON, Pose(np.array([0.0, 0.0, 2.0])))
    np.testing.assert_allclose(item.world_points, TETRAHEDRON + [0, 0, 2])


def test_points_cannot_be_changed_behind_a_scene():
    item = SceneObject('cup', TETRAHEDRON.copy(), Pose())
    with pytest.raises(ValueError, match='read-only'):
        item.points[0, 0] = 1.0


@pytest.mark.parametrize(
    ('points', 'reason'),
    [
        (np.zeros((0, 3)), '0 points'),
        (np.zeros((3, 3)), '3 points'),
        (np.zeros((5, 2)), 'shape'),
        (np.full((5, 3), np.nan), '5 of 5 points are not finite'),
    ],
)
def test_a_bad_cloud_names_the_object_and_the_reason(points, reason):
    with pytest.raises(InvalidSceneError, match=f'cup.*{reason}'):
        SceneObject('cup', points, Pose())


def test_a_scene_needs_two_objects():
    item = SceneObject('cup', TETRAHEDRON, Pose())
    with pytest.raises(InvalidSceneError, match="'cup' twice"):
        Scene(item, item)


def test_an_object_needs_a_name():
    with pytest.raises(InvalidSceneError, match='id'):
        SceneObject('', TETRAHEDRON, Pose())


def test_surface_samples_lie_on_the_surface_in_proportion_to_area():
    mesh = TriangleMesh(TETRAHEDRON, FACES)
    points = mesh.sample_surface(20000, np.random.default_rng(0))
    slanted = np.abs(points.sum(axis=1) - 1.0) < 1e-5
    on_axes = (np.abs(points) < 1e-6).any(axis=1)
    assert (slanted | on_axes).all()
    share = np.sqrt(3) / 2 / (np.sqrt(3) / 2 + 1.5)
    assert slanted.mean() == pytest.approx(share, abs=0.01)


@pytest.mark.parametrize(
    ('vertices', 'faces', 'reason'),
    [
        (TETRAHEDRON, np.array([[0, 1, 4]]), '0 to 4'),
        (np.full((4, 3), np.inf), FACES, 'not finite'),
        (TETRAHEDRON, np.zeros((0, 3), int), 'triangles'),
    ],
)
def test_a_bad_mesh_is_refused(vertices, faces, reason):
    with pytest.raises(InvalidSceneError, match=reason):
        TriangleMesh(vertices, faces)
