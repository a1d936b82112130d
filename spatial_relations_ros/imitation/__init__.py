"""Pose optimisation through the metric, and feasibility; no ROS."""

from spatial_relations_ros.imitation.imitate import imitate
from spatial_relations_ros.imitation.manipulation import ArmReach, Move, Obstacle
from spatial_relations_ros.imitation.options import ImitationOptions
from spatial_relations_ros.imitation.result import (
    ImitationAnswer,
    ImitationProgress,
    ImitationResult,
    ObjectPlacement,
    ProgressCallback,
)

__all__ = [
    'ArmReach',
    'ImitationAnswer',
    'ImitationOptions',
    'ImitationProgress',
    'ImitationResult',
    'Move',
    'ObjectPlacement',
    'Obstacle',
    'ProgressCallback',
    'imitate',
]
