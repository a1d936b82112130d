"""What the demonstration replays and asks for: bags/demo.yaml."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml  # type: ignore[import-untyped]

from spatial_relations_ros.core import ConfigError


@dataclass(frozen=True)
class PlannedImitation:
    """One request: base and relative of the demonstration and of the objects to place."""

    relation: str
    reference_ids: tuple[str, str]
    test_ids: tuple[str, str]


@dataclass(frozen=True)
class DemoPlan:
    """A bag with its topics and the requests; the first one is the main one."""

    bag: Path
    models_path: Path
    world_frame: str
    points_topic: str
    tracked_objects_topic: str
    imitations: tuple[PlannedImitation, ...]


def read_demo_plan(path: Path) -> DemoPlan:
    """Reads a plan; its paths are relative to its folder.

    Raises:
        ConfigError: when the file is missing, or a key is missing or of another type.
    """
    try:
        content = yaml.safe_load(path.read_text(encoding='utf-8'))
        return DemoPlan(
            bag=path.parent / str(content['bag']),
            models_path=path.parent / str(content['models_path']),
            world_frame=str(content['world_frame']),
            points_topic=str(content['points_topic']),
            tracked_objects_topic=str(content['tracked_objects_topic']),
            imitations=tuple(_imitation(item) for item in content['imitations']),
        )
    except OSError as error:
        raise ConfigError(f'{path} cannot be read: {error.strerror}') from error
    except KeyError as error:
        raise ConfigError(f'{path} lacks {error}') from error
    except (TypeError, ValueError, yaml.YAMLError) as error:
        raise ConfigError(f'{path} is no demonstration plan: {error}') from error


def _imitation(item: Any) -> PlannedImitation:
    (reference_base, reference_relative), (test_base, test_relative) = (
        (str(object_id) for object_id in item[key]) for key in ('reference_ids', 'test_ids')
    )
    return PlannedImitation(
        str(item['relation']), (reference_base, reference_relative), (test_base, test_relative)
    )
