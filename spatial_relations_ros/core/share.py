"""Where files lie: those that ship with the package, and those that a person keeps."""

from __future__ import annotations

import os
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


def data_path(*parts: str) -> Path:
    """Path of a file or folder that a person keeps: below XDG_DATA_HOME or ~/.local/share."""
    configured = os.environ.get('XDG_DATA_HOME', '')
    # The specification has relative paths ignored.
    data_home = (
        Path(configured) if Path(configured).is_absolute() else Path.home() / '.local/share'
    )
    return data_home.joinpath(PACKAGE_NAME, *parts)
