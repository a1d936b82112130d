"""Counting the scenes of a dataset that stay put."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from spatial_relations_ros.core import DatasetFormatError, Pose, Relation
from spatial_relations_ros.datasets.freiburg import RelationDataset, RelationScene
from spatial_relations_ros.datasets.objects.model_of_solid import model_of_solid
from spatial_relations_ros.datasets.objects.solids import box
from spatial_relations_ros.evaluation.settling import settle_scenes, summarize

mujoco = pytest.importorskip('mujoco')


def scene(name: str, x: float) -> RelationScene:
    """A cube on a cube; the table is not at z = 0."""
    identity = np.eye(3)
    return RelationScene(
        name,
        'low',
        'high',
        Pose.identity(),
        Pose.from_rotation(identity, np.array([x, 0.0, 0.1])),
        Relation.ON_TOP,
    )


@pytest.fixture(scope='module')
def dataset() -> RelationDataset:
    mesh = model_of_solid('cube', box((0.1, 0.1, 0.1)), {}).mesh
    clouds = dict.fromkeys(('low', 'high'), mesh.vertices)
    scenes = (scene('low_high_1', 0.02), scene('low_high_2', 0.08))
    return RelationDataset(clouds, scenes, (), (), {'low': mesh, 'high': mesh})


def test_what_stands_stays_and_what_hangs_over_falls(dataset):
    stood, fell = settle_scenes(dataset, dataset.scenes)
    assert stood.stayed
    assert not fell.stayed
    summary = summarize([stood, fell])
    assert list(summary) == ['on_top', 'all']
    assert summary['all']['scenes'] == 2
    assert summary['all']['stayed'] == 1
    low, high = summary['all']['wilson_95']
    assert low < 0.5 < high


def test_clouds_alone_cannot_fall(dataset):
    bare = dataclasses.replace(dataset, meshes={})
    with pytest.raises(DatasetFormatError, match='no mesh of low'):
        settle_scenes(bare, bare.scenes)
