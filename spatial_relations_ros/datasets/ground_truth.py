"""Reading the continuous ground truth that generated datasets carry beside the labels."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import DatasetFormatError, Relation
from spatial_relations_ros.datasets.freiburg.lines import read_lines

GROUND_TRUTH_FILE = 'ground_truth.jsonl'
MEASURES = ('lean', 'overhang', 'gap', 'depth')

_HALF_RIGHT_ANGLE_RAD = np.pi / 4.0
_LEANING = (Relation.INCLINED, Relation.INSIDE_INCLINED, Relation.INSIDE_LYING)
_INSIDE = (Relation.INSIDE, Relation.INSIDE_INCLINED, Relation.INSIDE_LYING)


def read_measures(folder: Path, scene_names: Sequence[str]) -> NDArray[np.float32] | None:
    """How each scene stands within its relation, in numbers of about one.

    Args:
        folder: of a dataset.
        scene_names: M names.

    Returns:
        (M, 4), columns as in ``MEASURES``: lean as a share of 45 degrees, the share of the foot
        that hangs over, twice the gap as a share of the scene's extent, the share of the
        relative's height below the rim. NaN where a measure says nothing of the relation or the
        scene has no line. None without a ground truth file.

    Raises:
        DatasetFormatError: for a line that cannot be read, with its number.
    """
    path = folder / GROUND_TRUTH_FILE
    if not path.is_file():
        return None
    rows: dict[str, list[float]] = {}
    for number, line in enumerate(read_lines(path), start=1):
        try:
            truth = json.loads(line)
            rows[truth['scene']] = _row(truth)
        except (ValueError, KeyError, TypeError, ArithmeticError) as error:
            raise DatasetFormatError(
                f'{path}, line {number}: {error!r}; expected a JSON object with scene, '
                'relation, lean_rad, overhang_share, clearance, extent and depth_share'
            ) from error
    unknown = [np.nan] * len(MEASURES)
    return np.array([rows.get(name, unknown) for name in scene_names], dtype=np.float32)


def _row(truth: dict[str, Any]) -> list[float]:
    relation = Relation(truth['relation'])
    lean = float(truth['lean_rad']) / _HALF_RIGHT_ANGLE_RAD
    gap = 2.0 * float(truth['clearance']) / float(truth['extent'])
    return [
        lean if relation in _LEANING else np.nan,
        _number(truth['overhang_share']) if relation is Relation.ON_TOP_EDGE else np.nan,
        gap if relation is Relation.NEXT_TO else np.nan,
        _number(truth['depth_share']) if relation in _INSIDE else np.nan,
    ]


def _number(value: float | None) -> float:
    return np.nan if value is None else float(value)
