"""Embeddings averaged over headings of the scene."""

import numpy as np
import pytest
import torch

from spatial_relations_ros.core import Pose, Scene
from spatial_relations_ros.learning import ModelCard, RelationMetric
from spatial_relations_ros.learning.encoders import make_encoder


@pytest.fixture
def encoder():
    return make_encoder('compact')


@pytest.fixture
def scene(solids):
    base = solids.box('base', (0.2, 0.12, 0.1), (0, 0, 0.05))
    return Scene(base, solids.box('relative', (0.08, 0.05, 0.07), (0.03, 0.02, 0.135)))


def turned(scene, angle_rad):
    turn = Pose(np.zeros(3), np.array([np.cos(angle_rad / 2), 0, 0, np.sin(angle_rad / 2)]))
    return scene.with_poses(*(turn @ item.world_from_object for item in scene.objects))


def test_the_average_is_that_of_the_turned_scenes(encoder, scene):
    one = RelationMetric(encoder, ModelCard('compact', 512))
    three = RelationMetric(encoder, ModelCard('compact', 512, headings=3))
    views = one.embed_scenes([turned(scene, k * np.pi / 3) for k in range(3)])
    np.testing.assert_allclose(three.embed_scenes([scene])[0], views.mean(axis=0), atol=2e-5)


def test_the_average_depends_less_on_the_heading(encoder, scene):
    def spread(headings):
        metric = RelationMetric(encoder, ModelCard('compact', 512, headings=headings))
        views = metric.embed_scenes([turned(scene, angle) for angle in np.linspace(0, 3, 7)])
        return np.linalg.norm(views - views.mean(axis=0), axis=1).mean()

    assert spread(4) < 0.6 * spread(1)


def test_batches_are_averaged_scene_by_scene(encoder, scene):
    metric = RelationMetric(encoder, ModelCard('compact', 256))
    points = torch.from_numpy(metric.scene_points(scene))
    other = points * torch.tensor([1.0, 1.0, 0.5])
    both = metric.embed(torch.stack([points, other]), headings=4)
    alone = metric.embed(other[None], headings=4)
    torch.testing.assert_close(both[1], alone[0], atol=1e-5, rtol=0.0)
