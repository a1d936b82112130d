"""Encoders, the metric and its training; no ROS."""

from spatial_relations_ros.learning.calibration import Calibration
from spatial_relations_ros.learning.card import ModelCard
from spatial_relations_ros.learning.encoders import (
    EMBEDDING_DIM,
    ENCODERS,
    Compact,
    Encoder,
    Jund2018,
    make_encoder,
)
from spatial_relations_ros.learning.losses import (
    all_pairs_contrastive_loss,
    euclidean_distance,
    triplet_contrastive_loss,
)
from spatial_relations_ros.learning.metric import Comparison, RelationMetric
from spatial_relations_ros.learning.weights import load_metric, save_metric

__all__ = [
    'EMBEDDING_DIM',
    'ENCODERS',
    'Calibration',
    'Compact',
    'Comparison',
    'Encoder',
    'Jund2018',
    'ModelCard',
    'RelationMetric',
    'all_pairs_contrastive_loss',
    'euclidean_distance',
    'load_metric',
    'make_encoder',
    'save_metric',
    'triplet_contrastive_loss',
]
