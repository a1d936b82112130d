"""Objects, poses and scenes; no ROS, no learning."""

from spatial_relations_ros.core.errors import (
    BagError,
    CloudFormatError,
    ConfigError,
    DatasetFormatError,
    FrameTransformError,
    ImitationError,
    InvalidPoseError,
    InvalidSceneError,
    MemoryFileError,
    ObjectExistsError,
    ObjectSizeError,
    RelationExistsError,
    SpatialRelationsError,
    TrainingError,
    UnknownObjectError,
    UnknownRelationError,
    WeightsError,
)
from spatial_relations_ros.core.files import atomic_write
from spatial_relations_ros.core.mesh import TriangleMesh
from spatial_relations_ros.core.pose import Pose
from spatial_relations_ros.core.relations import Relation
from spatial_relations_ros.core.scene import CloudSource, Scene, SceneObject
from spatial_relations_ros.core.share import data_path, executable_path, share_path

__all__ = [
    'BagError',
    'CloudFormatError',
    'CloudSource',
    'ConfigError',
    'DatasetFormatError',
    'FrameTransformError',
    'ImitationError',
    'InvalidPoseError',
    'InvalidSceneError',
    'MemoryFileError',
    'ObjectExistsError',
    'ObjectSizeError',
    'Pose',
    'Relation',
    'RelationExistsError',
    'Scene',
    'SceneObject',
    'SpatialRelationsError',
    'TrainingError',
    'TriangleMesh',
    'UnknownObjectError',
    'UnknownRelationError',
    'WeightsError',
    'atomic_write',
    'data_path',
    'executable_path',
    'share_path',
]
