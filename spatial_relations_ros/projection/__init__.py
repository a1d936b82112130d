"""Depth images of scenes and their gradients; no ROS."""

from spatial_relations_ros.projection.config import GRADIENTS, PLANES, ProjectionConfig
from spatial_relations_ros.projection.depth_images import project
from spatial_relations_ros.projection.image_arrows import image_arrows
from spatial_relations_ros.projection.normalization import fit_unit_cube
from spatial_relations_ros.projection.poses import apply_poses, resample_points
from spatial_relations_ros.projection.soft import coarse_to_fine
from spatial_relations_ros.projection.stencils import sobel_kernel

__all__ = [
    'GRADIENTS',
    'PLANES',
    'ProjectionConfig',
    'apply_poses',
    'coarse_to_fine',
    'fit_unit_cube',
    'image_arrows',
    'project',
    'resample_points',
    'sobel_kernel',
]
