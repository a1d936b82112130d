"""Physically plausible scenes of the seven relations."""

from spatial_relations_ros.datasets.generator.checks import Measured, measure
from spatial_relations_ros.datasets.generator.drawing import generate_objects
from spatial_relations_ros.datasets.generator.scenes import (
    GeneratedScene,
    SceneSampler,
    sample_scene,
)
from spatial_relations_ros.datasets.generator.writing import generate_dataset

__all__ = [
    'GeneratedScene',
    'Measured',
    'SceneSampler',
    'generate_dataset',
    'generate_objects',
    'measure',
    'sample_scene',
]
