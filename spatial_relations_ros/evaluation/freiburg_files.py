"""The published files of the Freiburg Spatial Relations data: real poses and their features."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import DatasetFormatError
from spatial_relations_ros.datasets.freiburg import SceneLine, read_scene_lines
from spatial_relations_ros.datasets.freiburg.lines import read_lines
from spatial_relations_ros.evaluation.hand_made_features import NUM_FEATURES

POSES_FILE = 'simtrack_with_unit_gravity.txt'
FEATURES_FILE = 'features_all_downsampled3cm.txt'

_SUM_TOLERANCE = 1e-3


def read_poses(folder: Path) -> list[SceneLine]:
    """The scenes of ``simtrack_with_unit_gravity.txt``.

    Raises:
        DatasetFormatError: with file and line, when it is missing or malformed.
    """
    return read_scene_lines(folder / POSES_FILE)


def read_features(path: Path, names: Sequence[str]) -> NDArray[np.float64]:
    """The hand-made features of scenes, from lines ``scene << 39 numbers``.

    Args:
        path: the file.
        names: scenes whose features are wanted.

    Returns:
        (len(names), 39) in their order.

    Raises:
        DatasetFormatError: with file and line, for a missing file or scene, malformed lines,
            another count of numbers, histograms that do not sum to one.
    """
    found: dict[str, NDArray[np.float64]] = {}
    for number, line in enumerate(read_lines(path), start=1):
        if not line.strip():
            continue
        name, mark, numbers = line.partition('<<')
        where = f'{path}:{number}'
        if not mark:
            raise DatasetFormatError(f'{where}: expected scene << numbers, got {line[:60]!r}')
        found[name.strip()] = _feature_row(numbers, where)
    absent = [name for name in names if name not in found]
    if absent:
        raise DatasetFormatError(
            f'{path}: {len(absent)} of {len(names)} scenes, such as {absent[0]}, have no features'
        )
    return np.stack([found[name] for name in names]) if names else np.zeros((0, NUM_FEATURES))


def _feature_row(text: str, where: str) -> NDArray[np.float64]:
    try:
        row = np.array([float(part) for part in text.replace(',', ' ').split()])
    except ValueError:
        raise DatasetFormatError(
            f'{where}: {text.strip()[:60]!r} is not made of numbers'
        ) from None
    if len(row) != NUM_FEATURES:
        raise DatasetFormatError(f'{where}: expected {NUM_FEATURES} numbers, got {len(row)}')
    sums = np.array([row[:18].sum(), row[18:36].sum(), row[36:].sum()])
    if not np.isfinite(row).all() or np.abs(sums - 1.0).max() > _SUM_TOLERANCE:
        raise DatasetFormatError(
            f'{where}: the histograms sum to {sums.round(4).tolist()}, not to one each'
        )
    return row
