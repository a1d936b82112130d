"""Settings of perception, in one tree."""

from __future__ import annotations

from dataclasses import dataclass, field

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.perception.accumulation import AccumulationConfig
from spatial_relations_ros.perception.cropping import CropConfig
from spatial_relations_ros.perception.evidence import SupportConfig
from spatial_relations_ros.perception.frames import TransformBufferConfig
from spatial_relations_ros.perception.jumps import JumpConfig
from spatial_relations_ros.perception.refine import RefineConfig
from spatial_relations_ros.perception.track_state import TrackStateConfig
from spatial_relations_ros.perception.tracks import TrackConfig


@dataclass(frozen=True)
class PerceptionConfig:
    """How clouds and tracked poses become objects.

    Attributes:
        world_frame: the frame of all results, z up against gravity.
        object_frames: objects whose pose is a frame of /tf of the same name.
        tracks: which tracked poses can be used at a cloud's time.
        transforms: limits of the transform buffer.
        support: how much of an object the cloud must confirm.
        jumps: what an object cannot do.
        states: how the belief in an object changes.
        use_uncertain: whether objects in the state UNCERTAIN are used too.
        refine: whether and how poses are moved to what the cloud shows.
        crop: how objects without a model are cut out.
        accumulation: how much is remembered of objects without a model.
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
    support: SupportConfig = field(default_factory=SupportConfig)
    jumps: JumpConfig = field(default_factory=JumpConfig)
    states: TrackStateConfig = field(default_factory=TrackStateConfig)
    use_uncertain: bool = False
    refine: RefineConfig = field(default_factory=RefineConfig)
    crop: CropConfig = field(default_factory=CropConfig)
    accumulation: AccumulationConfig = field(default_factory=AccumulationConfig)
    max_range: float = 4.0
    thin_stride: int = 4
    table_reach: float = 0.4
    find_obstacles: bool = False
    seed: int = 0

    def __post_init__(self) -> None:
        if not self.world_frame:
            raise ConfigError('world_frame is empty')
        if not (self.max_range > 0 and self.table_reach > 0):
            raise ConfigError(f'ranges must be positive, got {self}')
        if not 1 <= self.thin_stride <= 64:
            raise ConfigError(f'thin_stride is {self.thin_stride}, expected 1 to 64')
