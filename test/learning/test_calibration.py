import dataclasses

import numpy as np
import pytest
import torch

from spatial_relations_ros.core import WeightsError
from spatial_relations_ros.learning import (
    Calibration,
    ModelCard,
    load_metric,
    make_encoder,
    save_metric,
)


@pytest.fixture
def calibration():
    return Calibration(
        np.array([0.1, 0.5, 0.7, 2.0]),
        np.array([0.9, 0.9, 0.1, 0.0]),
        np.array([[0.0, 0.0], [3.0, 4.0]], dtype=np.float32),
        0.5,
    )


def test_probability_falls_linearly_between_knots_and_is_constant_outside(calibration):
    for distance, expected in ((0.0, 0.9), (0.3, 0.9), (0.6, 0.5), (0.7, 0.1), (9.0, 0.0)):
        assert calibration.same_relation_probability(distance) == pytest.approx(expected)
    assert calibration.same_relation_distance == pytest.approx(0.6, abs=1e-6)


def test_novelty_is_the_distance_to_the_nearest_prototype_over_the_threshold(calibration):
    points = np.array([[0.0, 0.0], [0.3, 0.0], [3.0, 3.4], [10.0, 0.0]])
    expected = [
        min(np.linalg.norm(point - prototype) for prototype in calibration.prototypes) / 0.5
        for point in points
    ]
    np.testing.assert_allclose(calibration.novelty(points), expected, atol=1e-9)
    assert [calibration.is_novel(point) for point in points] == [False, False, True, True]
    assert calibration.is_novel(np.array([np.nan, 0.0]))


def test_it_travels_with_the_weights(calibration, tmp_path):
    torch.manual_seed(0)
    encoder, path = make_encoder('compact'), tmp_path / 'weights.safetensors'
    bare = save_metric(encoder, ModelCard('compact', num_points=256), path)
    assert load_metric(path).calibration is None
    card = save_metric(encoder, ModelCard('compact', num_points=256), path,
                       calibration=calibration)  # fmt: skip
    assert card.sha256 != bare.sha256
    loaded = load_metric(path)
    assert loaded.calibration is not None
    for name in ('distances', 'probabilities', 'prototypes'):
        assert np.array_equal(getattr(loaded.calibration, name), getattr(calibration, name))
    assert loaded.calibration.novelty_distance == 0.5
    for name, tensor in encoder.state_dict().items():
        assert torch.equal(tensor, loaded.encoder.state_dict()[name]), name


def test_half_a_calibration_is_refused(calibration):
    tensors = calibration.tensors()
    del tensors['calibration.prototypes']
    with pytest.raises(WeightsError, match='prototypes'):
        Calibration.of_tensors(tensors)
    tensors = calibration.tensors() | {'calibration.distances': torch.tensor([1.0, 0.0, 2.0, 3.0])}
    with pytest.raises(WeightsError, match='cannot be used'):
        Calibration.of_tensors(tensors)


@pytest.mark.parametrize(
    ('name', 'values'),
    [('probabilities', [np.nan, 0.5, 0.1, 0.0]), ('probabilities', [3.0, 0.5, 0.1, 0.0]),
     ('probabilities', [0.1, 0.5, 0.1, 0.0]), ('distances', [0.1, 0.5, 0.7, np.inf]),
     ('prototypes', [[0.0, np.nan]]), ('novelty_distance', np.inf)],
)  # fmt: skip
def test_numbers_that_mean_nothing_are_refused(calibration, name, values):
    with pytest.raises(WeightsError, match='cannot be used'):
        dataclasses.replace(calibration, **{name: np.asarray(values)})
