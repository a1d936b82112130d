"""Settings of perception, in one tree."""

from __future__ import annotations

from dataclasses import dataclass, field

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.perception.cropping import CropConfig
from spatial_relations_ros.perception.frames import TransformBufferConfig
from spatial_relations_ros.perception.tracks import TrackConfig


@dataclass(frozen=True)
class PerceptionConfig:
    """How clouds and tracked poses become objects.

    Attributes:
        world_frame: the frame of all results, z up against gravity.
        object_frames: objects whose pose is a frame of /tf of the same name.
        tracks: when a tracked pose is believed.
        transforms: limits of the transform buffer.
        crop: how objects without a model are cut out.
        min_support: an object that the cloud confirms less is refused; 0 believes every tracker.
        support_tolerance: depth difference that is still the same surface, metres.
        max_range: farther points are ignored, metres.
        thin_stride: every how many-th row and column the table is looked for in.
        table_reach: how far around the objects the table is looked for, metres.
        find_obstacles: whether points above the table that belong to no object are returned.
        seed: of the table search.
    """

    world_frame: str = 'world'
    object_frames: tuple[str, ...] = ()
    tracks: TrackConfig = field(default_factory=TrackConfig)
    transforms: TransformBufferConfig = field(default_factory=TransformBufferConfig)
    crop: CropConfig = field(default_factory=CropConfig)
    min_support: float = 0.2
    support_tolerance: float = 0.02
    max_range: float = 4.0
    thin_stride: int = 4
    table_reach: float = 0.4
    find_obstacles: bool = False
    seed: int = 0

    def __post_init__(self) -> None:
        if not self.world_frame:
            raise ConfigError('world_frame is empty')
        if not 0 <= self.min_support <= 1:
            raise ConfigError(f'min_support is {self.min_support}, expected 0 to 1')
        if not (self.support_tolerance > 0 and self.max_range > 0 and self.table_reach > 0):
            raise ConfigError(f'tolerances and ranges must be positive, got {self}')
        if not 1 <= self.thin_stride <= 64:
            raise ConfigError(f'thin_stride is {self.thin_stride}, expected 1 to 64')
