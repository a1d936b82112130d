"""Pose optimisation through the metric, and feasibility; no ROS."""

from spatial_relations_ros.imitation.imitate import imitate
from spatial_relations_ros.imitation.options import ImitationOptions
from spatial_relations_ros.imitation.result import (
    ImitationAnswer,
    ImitationProgress,
    ImitationResult,
    ObjectPlacement,
    ProgressCallback,
)

__all__ = [
    'ImitationAnswer',
    'ImitationOptions',
    'ImitationProgress',
    'ImitationResult',
    'ObjectPlacement',
    'ProgressCallback',
    'imitate',
]
