"""Parameters of perception_node."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.perception.config import PerceptionConfig
from spatial_relations_ros.perception.object_models import ModelSource, NoModels
from spatial_relations_ros.perception.tracks import TrackConfig
from spatial_relations_ros.pipeline import LibraryModels, Pipeline
from spatial_relations_ros.ros.parameters import Parameters, ParameterSpec

DEFAULTS = PerceptionConfig()

MODELS_PATH = ParameterSpec(
    'models_path',
    '',
    'Folder of object models, one file <object id>.ply, .pcd, .obj, .stl or .off in metres each; '
    'empty: objects are taken from the live cloud.',
    is_fixed=True,
)
PERCEPTION_PARAMETERS = (
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
        'pairs', [], 'Scenes to publish, "base/relative" each; empty: all ordered pairs.'
    ),
    ParameterSpec(
        'publish_rate',
        5.0,
        'Highest rate of ~/scenes and ~/markers, Hz; the service always has the latest cloud.',
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
        is_fixed=True,
    ),
    ParameterSpec(
        'min_confidence',
        DEFAULTS.tracks.min_confidence,
        'Tracked poses of less confidence are refused.',
        minimum=0.0,
        maximum=1.0,
        is_fixed=True,
    ),
    ParameterSpec(
        'min_support',
        DEFAULTS.min_support,
        'Share of a model that the cloud must confirm; 0 believes every tracker.',
        minimum=0.0,
        maximum=1.0,
        is_fixed=True,
    ),
    ParameterSpec(
        'max_range',
        DEFAULTS.max_range,
        'Points farther from the sensor are ignored, metres.',
        minimum=0.1,
        maximum=100.0,
        is_fixed=True,
    ),
)


def make_pipeline(parameters: Parameters) -> Pipeline:
    """Perception as the parameters say.

    Raises:
        ConfigError: when a value cannot be used.
        DatasetFormatError: when the models' folder does not exist.
    """
    ordered_pairs(parameters.texts('pairs'))
    config = PerceptionConfig(
        world_frame=parameters.text('world_frame'),
        object_frames=tuple(parameters.texts('object_frames')),
        tracks=TrackConfig(
            max_age_sec=parameters.number('max_track_age'),
            min_confidence=parameters.number('min_confidence'),
        ),
        min_support=parameters.number('min_support'),
        max_range=parameters.number('max_range'),
    )
    return Pipeline(config, model_source(parameters.text('models_path')))


def model_source(folder: str) -> ModelSource:
    """Models of a folder; without a folder there are none."""
    return LibraryModels(Path(folder).expanduser()) if folder else NoModels()


def ordered_pairs(entries: Sequence[str]) -> list[tuple[str, str]]:
    """Base and relative ids of entries "base/relative".

    Raises:
        ConfigError: for an entry that is no pair of different ids.
    """
    pairs = []
    for entry in entries:
        base_id, _, relative_id = entry.partition('/')
        if not base_id or not relative_id or base_id == relative_id:
            raise ConfigError(f'pairs has {entry!r}; expected "base/relative"')
        pairs.append((base_id, relative_id))
    return pairs


def pose_topic(entry: str) -> tuple[str, str]:
    """Object id and topic of one entry of ``pose_topics``.

    ``/simtrack/bowl`` is the topic of the object ``bowl``; ``cup=/some/pose`` names the object.

    Raises:
        ConfigError: for an entry without an object id or a topic.
    """
    object_id, separator, topic = entry.partition('=')
    if not separator:
        object_id, topic = entry.rstrip('/').rpartition('/')[2], entry
    if not object_id or not topic:
        raise ConfigError(f'pose_topics has {entry!r}; expected "/topic/id" or "id=/topic"')
    return object_id, topic
