"""Parameters of perception_node."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from spatial_relations_ros.core import ConfigError, InvalidPoseError, Pose
from spatial_relations_ros.core.rotations import wxyz_from_xyzw
from spatial_relations_ros.nodes.node_recording import RERUN
from spatial_relations_ros.perception.assembler import AssemblyConfig
from spatial_relations_ros.perception.border import StampedTransform
from spatial_relations_ros.perception.config import PerceptionConfig
from spatial_relations_ros.perception.evidence import SupportConfig
from spatial_relations_ros.perception.frames import TransformBufferConfig
from spatial_relations_ros.perception.jumps import JumpConfig
from spatial_relations_ros.perception.object_models import ModelSource, NoModels
from spatial_relations_ros.perception.refine import RefineConfig
from spatial_relations_ros.perception.track_state import TrackStateConfig
from spatial_relations_ros.perception.tracks import TrackConfig
from spatial_relations_ros.pipeline import LibraryModels, Pipeline
from spatial_relations_ros.ros.parameters import Parameters, ParameterSpec

DEFAULTS = PerceptionConfig()
ASSEMBLY_DEFAULTS = AssemblyConfig()

MODELS_PATH = ParameterSpec(
    'models_path',
    '',
    'Folder of object models, one file <object id>.ply, .pcd, .obj, .stl or .off in metres each; '
    'empty: objects are taken from the live cloud.',
    is_fixed=True,
)
PERCEPTION_PARAMETERS = (
    RERUN,
    ParameterSpec(
        'world_frame',
        DEFAULTS.world_frame,
        'Frame of everything published, z up against gravity.',
        is_fixed=True,
    ),
    MODELS_PATH,
    ParameterSpec(
        'pose_topics',
        [],
        'PoseStamped topics, one an object: "/simtrack/bowl" for the object bowl, or '
        '"cup=/any/topic".',
        is_fixed=True,
    ),
    ParameterSpec(
        'object_frames', [], 'Objects whose pose is the /tf frame of that name.', is_fixed=True
    ),
    ParameterSpec(
        'pairs',
        [],
        'Scenes to publish, "base/relative" each; empty: all ordered pairs.',
        check=lambda entries: ordered_pairs(entries),
    ),
    ParameterSpec(
        'publish_rate',
        30.0,
        'Highest rate of ~/scenes and ~/markers, Hz; the service always has the latest cloud. '
        'With many objects name the pairs that are wanted: ten objects make 90 scenes a cloud.',
        minimum=0.01,
        maximum=100.0,
    ),
    ParameterSpec(
        'reliable_points',
        False,
        'Ask for reliable delivery of clouds; only publishers that offer it are received then.',
        is_fixed=True,
    ),
    ParameterSpec(
        'max_age',
        10.0,
        'Scenes of a cloud that arrived longer ago are refused, seconds; 0: any age.',
        minimum=0.0,
        maximum=1e6,
    ),
    ParameterSpec(
        'max_track_age',
        DEFAULTS.tracks.max_age_sec,
        "How old a tracked pose may be at the cloud's time, seconds.",
        minimum=0.0,
        maximum=60.0,
    ),
    ParameterSpec(
        'pose_wait',
        ASSEMBLY_DEFAULTS.pose_wait_sec,
        'How long a cloud waits for tracked poses at or after its stamp, seconds; 0: it takes '
        'what is there.',
        minimum=0.0,
        maximum=10.0,
    ),
    ParameterSpec(
        'min_confidence',
        DEFAULTS.tracks.min_confidence,
        'Tracked poses of less confidence are refused.',
        minimum=0.0,
        maximum=1.0,
    ),
    ParameterSpec(
        'min_support',
        DEFAULTS.support.min_support,
        "Share of a model's visible surface that the cloud must confirm; 0 believes every "
        'tracker.',
        minimum=0.0,
        maximum=1.0,
    ),
    ParameterSpec(
        'support_hysteresis',
        DEFAULTS.support.hysteresis,
        'How much more support than min_support it takes to believe a new pose.',
        minimum=0.0,
        maximum=1.0,
    ),
    ParameterSpec(
        'support_tolerance',
        DEFAULTS.support.tolerance,
        'Depth difference that is still the same surface, metres.',
        minimum=0.001,
        maximum=0.5,
    ),
    ParameterSpec(
        'lost_after',
        DEFAULTS.states.lost_after_sec,
        'An object without support is UNCERTAIN for this long, then LOST, seconds.',
        minimum=0.0,
        maximum=60.0,
    ),
    ParameterSpec(
        'recover_after',
        DEFAULTS.states.recover_sec,
        'How long clouds must confirm a lost object, seconds.',
        minimum=0.0,
        maximum=60.0,
    ),
    ParameterSpec(
        'max_speed',
        DEFAULTS.jumps.max_speed,
        'A tracked pose that moves faster has jumped, m/s.',
        minimum=0.1,
        maximum=1e6,
    ),
    ParameterSpec(
        'jump_settle',
        DEFAULTS.jumps.settle_sec,
        'How long clouds must confirm an object that has jumped, seconds.',
        minimum=0.0,
        maximum=60.0,
    ),
    ParameterSpec(
        'swap_settle',
        DEFAULTS.jumps.swap_settle_sec,
        'How long clouds must confirm two objects that have changed places at once, seconds.',
        minimum=0.0,
        maximum=600.0,
    ),
    ParameterSpec(
        'use_uncertain',
        DEFAULTS.use_uncertain,
        'Give scenes of UNCERTAIN objects too; those of LOST objects are never given.',
    ),
    ParameterSpec(
        'refine',
        DEFAULTS.refine.is_on,
        'Move poses of objects with a model to what the cloud shows (point-to-plane ICP), where '
        'support rises.',
    ),
    ParameterSpec(
        'max_extrapolation',
        DEFAULTS.transforms.max_extrapolation_sec,
        'How far outside of its samples a moving transform is believed, seconds.',
        minimum=0.0,
        maximum=60.0,
        is_fixed=True,
    ),
    ParameterSpec(
        'camera_pose',
        '',
        "Pose of the cloud's frame in world_frame where /tf does not tell: "
        '"x y z qx qy qz qw", metres.',
        is_fixed=True,
    ),
    ParameterSpec(
        'camera_frame', '', 'Frame of the cloud that camera_pose is for.', is_fixed=True
    ),
    ParameterSpec(
        'max_range',
        DEFAULTS.max_range,
        'Points farther from the sensor are ignored, metres.',
        minimum=0.1,
        maximum=100.0,
    ),
    ParameterSpec(
        'find_clutter',
        False,
        'Look for points above the table that belong to no object: obstacles for imitate_node.',
    ),
)

# What perception is made of anew with when one of them is set.
PIPELINE_PARAMETERS = (
    'max_track_age', 'min_confidence', 'min_support', 'support_hysteresis', 'support_tolerance',
    'lost_after', 'recover_after', 'max_speed', 'jump_settle', 'swap_settle', 'use_uncertain',
    'refine', 'max_range', 'find_clutter',
)  # fmt: skip
ASSEMBLY_PARAMETERS = ('pose_wait',)


def perception_config(parameters: Parameters) -> PerceptionConfig:
    """How clouds and poses become objects, as the parameters say now."""
    return PerceptionConfig(
        world_frame=parameters.text('world_frame'),
        object_frames=tuple(parameters.texts('object_frames')),
        tracks=TrackConfig(
            max_age_sec=parameters.number('max_track_age'),
            min_confidence=parameters.number('min_confidence'),
        ),
        transforms=TransformBufferConfig(
            max_extrapolation_sec=parameters.number('max_extrapolation')
        ),
        support=SupportConfig(
            min_support=parameters.number('min_support'),
            hysteresis=parameters.number('support_hysteresis'),
            tolerance=parameters.number('support_tolerance'),
        ),
        jumps=JumpConfig(
            max_speed=parameters.number('max_speed'),
            settle_sec=parameters.number('jump_settle'),
            swap_settle_sec=parameters.number('swap_settle'),
        ),
        states=TrackStateConfig(
            lost_after_sec=parameters.number('lost_after'),
            recover_sec=parameters.number('recover_after'),
        ),
        use_uncertain=parameters.flag('use_uncertain'),
        refine=RefineConfig(is_on=parameters.flag('refine')),
        max_range=parameters.number('max_range'),
        find_obstacles=parameters.flag('find_clutter'),
    )


def make_pipeline(parameters: Parameters) -> Pipeline:
    """Perception as the parameters say.

    Raises:
        ConfigError: when a value cannot be used.
        FrameTransformError: when camera_frame is the world itself.
        DatasetFormatError: when the models' folder does not exist.
    """
    config = perception_config(parameters)
    pipeline = Pipeline(config, model_source(parameters.text('models_path')))
    camera = camera_transform(
        parameters.text('camera_pose'), parameters.text('camera_frame'), config.world_frame
    )
    if camera is not None:
        pipeline.add_transform(camera)
    return pipeline


def assembly_config(parameters: Parameters) -> AssemblyConfig:
    """How clouds wait for their poses, as the parameters say now."""
    return AssemblyConfig(
        pose_wait_sec=parameters.number('pose_wait'),
        object_frames=tuple(parameters.texts('object_frames')),
    )


def camera_transform(pose: str, frame_id: str, world_frame: str) -> StampedTransform | None:
    """The static transform of the parameters ``camera_pose`` and ``camera_frame``.

    Args:
        pose: "x y z qx qy qz qw", or empty.
        frame_id: of the cloud.
        world_frame: in which the pose is given.

    Returns:
        None when no pose is given.

    Raises:
        ConfigError: when the pose is none, or comes without a frame.
    """
    if not pose.strip():
        return None
    if not frame_id:
        raise ConfigError('camera_pose needs camera_frame, the frame_id of the clouds')
    try:
        numbers = np.array([float(word) for word in pose.replace(',', ' ').split()])
        if len(numbers) != 7:
            raise ValueError(f'{len(numbers)} numbers')
        world_from_camera = Pose(numbers[:3], wxyz_from_xyzw(numbers[3:]))
    except (ValueError, InvalidPoseError) as error:
        raise ConfigError(
            f'camera_pose is {pose!r}, expected "x y z qx qy qz qw": {error}'
        ) from error
    return StampedTransform(world_frame, frame_id, 0, world_from_camera, is_static=True)


def model_source(folder: str) -> ModelSource:
    """Models of a folder; without a folder there are none."""
    return LibraryModels(Path(folder).expanduser()) if folder else NoModels()


def ordered_pairs(entries: Sequence[str], *, name: str = 'pairs') -> list[tuple[str, str]]:
    """Base and relative ids of entries "base/relative".

    Args:
        entries: of a parameter.
        name: of that parameter, for errors.

    Raises:
        ConfigError: for an entry that is no pair of different ids.
    """
    pairs = []
    for entry in entries:
        base_id, _, relative_id = entry.partition('/')
        if not base_id or not relative_id or base_id == relative_id:
            raise ConfigError(f'{name} has {entry!r}; expected "base/relative"')
        pairs.append((base_id, relative_id))
    return pairs
