"""What is kept of an object's model."""

import numpy as np

from spatial_relations_ros.perception.object_models import KnownModel, NoModels


def test_support_points_are_an_even_choice_of_the_model():
    line = np.zeros((5001, 3), dtype=np.float32)
    line[:, 0] = np.linspace(0, 1, 5001)
    picked = KnownModel(line).support_points[:, 0]
    assert len(picked) == 1000
    np.testing.assert_allclose(np.diff(picked), 1 / 999, atol=3e-4)
    np.testing.assert_array_equal(KnownModel(line[:300]).support_points, line[:300])


def test_without_models_nothing_is_found():
    assert NoModels().find('cup') is None
