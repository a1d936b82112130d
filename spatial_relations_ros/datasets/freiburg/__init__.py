"""The folder format of the Freiburg Spatial Relations data, read and written."""

from spatial_relations_ros.core import DatasetFormatError
from spatial_relations_ros.datasets.freiburg.dataset import (
    RelationDataset,
    RelationScene,
    Split,
)
from spatial_relations_ros.datasets.freiburg.lines import (
    SceneLine,
    format_scene_line,
    parse_scene_line,
    read_labels,
    read_scene_lines,
)
from spatial_relations_ros.datasets.freiburg.loading import load_dataset
from spatial_relations_ros.datasets.freiburg.writing import write_dataset

__all__ = [
    'DatasetFormatError',
    'RelationDataset',
    'RelationScene',
    'SceneLine',
    'Split',
    'format_scene_line',
    'load_dataset',
    'parse_scene_line',
    'read_labels',
    'read_scene_lines',
    'write_dataset',
]
