"""The projection's settings of a metric, for a while."""

import pytest
import torch

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.learning import ModelCard, RelationMetric, load_metric, make_encoder


@pytest.fixture(scope='module')
def metric():
    torch.manual_seed(0)
    return RelationMetric(make_encoder('compact'), ModelCard('compact', num_points=256))


def test_other_settings_hold_within_the_block_alone(metric):
    points = torch.rand(1, 2, 256, 3, generator=torch.Generator().manual_seed(0))
    usual = metric.embed(points)
    with metric.projecting(gradient='sobel'):
        assert metric.encoder.projection.gradient == 'sobel'
        assert torch.equal(metric.embed(points), usual)
        with metric.projecting(gradient='soft'):
            assert not torch.equal(metric.embed(points), usual)
    assert metric.encoder.projection.gradient == 'silhouette'
    with pytest.raises(RuntimeError, match='on purpose'), metric.projecting(splat_px=5):
        raise RuntimeError('on purpose')
    assert torch.equal(metric.embed(points), usual)


def test_impossible_settings_are_refused_and_change_nothing(metric):
    with pytest.raises(ConfigError, match='silhouette'), metric.projecting(gradient='hard'):
        pass
    assert metric.encoder.projection.gradient == 'silhouette'


def test_a_metric_is_loaded_with_another_gradient():
    assert load_metric(gradient='released').encoder.projection.gradient == 'released'
    assert load_metric().encoder.projection.gradient == 'silhouette'
    with pytest.raises(ConfigError, match='silhouette'):
        load_metric(gradient='hard')


def test_the_network_of_the_released_code_has_its_gradient():
    assert make_encoder('jund2018_released').projection.gradient == 'released'
    assert make_encoder('jund2018').projection.gradient == 'sobel'
