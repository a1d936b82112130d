"""Clouds and tracked poses in, objects in the world out; no ROS."""

from spatial_relations_ros.perception.accumulation import AccumulationConfig
from spatial_relations_ros.perception.assembler import AssemblyConfig, FrameAssembler
from spatial_relations_ros.perception.border import (
    Frame,
    FrameResult,
    StampedTransform,
    TrackedPose,
    TrackFault,
)
from spatial_relations_ros.perception.camera import PinholeCamera, estimate_camera
from spatial_relations_ros.perception.config import PerceptionConfig
from spatial_relations_ros.perception.cropping import CropConfig
from spatial_relations_ros.perception.evidence import SupportConfig
from spatial_relations_ros.perception.frames import TransformBuffer, TransformBufferConfig
from spatial_relations_ros.perception.jumps import JumpConfig
from spatial_relations_ros.perception.object_models import KnownModel, ModelSource, NoModels
from spatial_relations_ros.perception.point_cloud2 import PointCloud, read_xyz
from spatial_relations_ros.perception.refine import PoseRefiner, RefineConfig
from spatial_relations_ros.perception.scene_perception import ScenePerception
from spatial_relations_ros.perception.track_state import (
    TrackState,
    TrackStateConfig,
    TrackStatus,
)
from spatial_relations_ros.perception.tracks import TrackConfig

__all__ = [
    'AccumulationConfig',
    'AssemblyConfig',
    'CropConfig',
    'Frame',
    'FrameAssembler',
    'FrameResult',
    'JumpConfig',
    'KnownModel',
    'ModelSource',
    'NoModels',
    'PerceptionConfig',
    'PinholeCamera',
    'PointCloud',
    'PoseRefiner',
    'RefineConfig',
    'ScenePerception',
    'StampedTransform',
    'SupportConfig',
    'TrackConfig',
    'TrackFault',
    'TrackState',
    'TrackStateConfig',
    'TrackStatus',
    'TrackedPose',
    'TransformBuffer',
    'TransformBufferConfig',
    'estimate_camera',
    'read_xyz',
]
