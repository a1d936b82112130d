"""Every error that this package raises on purpose, under one root.

A message says what was got and what would have worked.
"""


class SpatialRelationsError(Exception):
    """Root of all errors that this package raises on purpose."""


class InvalidPoseError(SpatialRelationsError):
    """A pose with non-finite numbers or a quaternion that is not a rotation."""


class InvalidSceneError(SpatialRelationsError):
    """A scene or an object that cannot be used: too few points, equal ids, non-finite points."""


class CloudFormatError(SpatialRelationsError):
    """A point cloud message or file whose layout cannot be read."""


class DatasetFormatError(SpatialRelationsError):
    """A dataset folder with missing or malformed files."""


class WeightsError(SpatialRelationsError):
    """Weights that are missing, damaged, or belong to another network."""


class ConfigError(SpatialRelationsError):
    """A parameter or configuration value that cannot be used."""


class TrainingError(SpatialRelationsError):
    """A training that has come to numbers that are not finite."""


class UnknownObjectError(SpatialRelationsError):
    """An object id that nobody has seen."""


class ObjectSizeError(SpatialRelationsError):
    """An object model that is far too large or small: another unit than metres."""


class ObjectExistsError(SpatialRelationsError):
    """An object of that name that is in the library already."""


class UnknownRelationError(SpatialRelationsError):
    """A remembered relation's name that is not stored."""


class RelationExistsError(SpatialRelationsError):
    """A relation that is already remembered under that name."""


class MemoryFileError(SpatialRelationsError):
    """A file of remembered relations that cannot be opened, read or written."""


class FrameTransformError(SpatialRelationsError):
    """A transform between two frames that is not known at the asked time."""


class BagError(SpatialRelationsError):
    """A bag that is missing, empty, or lacks the topics that are needed."""


class ImitationError(SpatialRelationsError):
    """An imitation request that cannot be carried out."""
