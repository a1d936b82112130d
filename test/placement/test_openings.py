import numpy as np
import pytest

from spatial_relations_ros.core import TriangleMesh
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.datasets.objects import sample_object
from spatial_relations_ros.placement.openings import find_opening


@pytest.mark.parametrize('family', ['pot', 'basket', 'drawer', 'mug', 'crate', 'bucket'])
def test_the_opening_of_a_container_is_measured_on_its_mesh(family):
    model = sample_object(family, np.random.default_rng(3))
    found = find_opening(model.mesh)
    np.testing.assert_allclose(found.rotation[2], [0, 0, 1], atol=1e-6)
    assert found.opening.is_round == model.opening.is_round
    assert found.opening.depth == pytest.approx(model.opening.depth, rel=0.06)
    assert sorted(found.opening.rim_half_size) == pytest.approx(
        sorted(model.opening.rim_half_size), rel=0.12
    )


def test_an_opening_to_any_side_becomes_upwards():
    model = sample_object('crate', np.random.default_rng(0))
    turn = matrix_from_rotvec(np.array([0.5 * np.pi, 0.0, 0.0]))
    turned = TriangleMesh((model.mesh.vertices @ turn.T).astype(np.float32), model.mesh.triangles)
    found = find_opening(turned)
    np.testing.assert_allclose(found.rotation @ turn[:, 2], [0, 0, 1], atol=1e-6)
    assert found.opening.depth == pytest.approx(model.opening.depth, rel=0.06)
    assert sorted(found.opening.rim_half_size) == pytest.approx(
        sorted(model.opening.rim_half_size), rel=0.06
    )


@pytest.mark.parametrize('family', ['book', 'brick', 'bottle'])
def test_what_has_no_hollow_has_no_opening(family):
    assert find_opening(sample_object(family, np.random.default_rng(1)).mesh) is None
