"""Where files lie: those that ship with the package, and those that a person keeps."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

from spatial_relations_ros.core.errors import ConfigError

PACKAGE_NAME = 'spatial_relations_ros'


def share_path(*parts: str) -> Path:
    """Path of a file or folder that ships with the package.

    In a source checkout this is below the repository; installed it is
    ``<prefix>/share/spatial_relations_ros``. AMENT_PREFIX_PATH is not needed.

    Raises:
        ConfigError: when the file is in neither place.
    """
    package_dir = Path(__file__).resolve().parents[1]
    repository = package_dir.parent
    candidates = [repository] if (repository / 'package.xml').is_file() else []
    candidates += [parent / 'share' / PACKAGE_NAME for parent in package_dir.parents]
    for candidate in candidates:
        path = candidate.joinpath(*parts)
        if path.exists():
            return path
    searched = ', '.join(str(candidate) for candidate in candidates[:3])
    raise ConfigError(f'{"/".join(parts)} is not installed; searched {searched}')


def executable_path(name: str) -> Path:
    """The executable that ``ros2 run spatial_relations_ros NAME`` starts.

    Raises:
        ConfigError: when the package is not installed.
    """
    prefixes = [sys.prefix, *os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)]
    paths = [Path(prefix) / 'lib' / PACKAGE_NAME / name for prefix in prefixes if prefix]
    on_path = shutil.which(name)
    for path in [*paths, *([Path(on_path)] if on_path else [])]:
        if path.is_file():
            return path
    searched = ', '.join(str(path.parent) for path in paths)
    raise ConfigError(f'{name} is not installed; searched {searched}. Run `make build`.')


def data_path(*parts: str) -> Path:
    """Path of a file or folder that a person keeps: below XDG_DATA_HOME or ~/.local/share."""
    configured = os.environ.get('XDG_DATA_HOME', '')
    # The specification has relative paths ignored.
    data_home = (
        Path(configured) if Path(configured).is_absolute() else Path.home() / '.local/share'
    )
    return data_home.joinpath(PACKAGE_NAME, *parts)
