"""Poses of a scene as JSON: ``{"base": {"t": [x, y, z], "q_wxyz": [w, x, y, z]}, ...}``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from spatial_relations_ros.core import Pose

ROLES = ('base', 'relative')
EXAMPLE = '{"base": {"t": [0, 0, 0], "q_wxyz": [1, 0, 0, 0]}, "relative": {...}}'
GRASP_EXAMPLE = '{"relative": {"t": [0, 0, 0.1], "q_wxyz": [0, 1, 0, 0]}}'


def read_pose_file(path: Path) -> tuple[Pose, Pose]:
    """Poses of base and relative in the world, metres, z up.

    Raises:
        InvalidPoseError: saying which entry of which file is wrong, and how.
    """
    content = _read(path, EXAMPLE)
    base, relative = (_pose(path, content, role, EXAMPLE) for role in ROLES)
    return base, relative


def read_grasp_file(path: Path) -> dict[str, Pose]:
    """Grasps (object_from_gripper, metres) by role: base, relative or both.

    Raises:
        InvalidPoseError: saying which entry of which file is wrong, and how.
    """
    from spatial_relations_ros.core import InvalidPoseError

    content = _read(path, GRASP_EXAMPLE)
    if not content:
        raise InvalidPoseError(f'{path} holds no grasp; expected {GRASP_EXAMPLE}')
    return {role: _pose(path, content, role, GRASP_EXAMPLE) for role in content}


def _read(path: Path, example: str) -> dict[str, Any]:
    from spatial_relations_ros.core import InvalidPoseError

    try:
        content = json.loads(path.read_text())
    except OSError as error:
        raise InvalidPoseError(f'{path} cannot be read: {error.strerror}') from None
    except ValueError as error:
        raise InvalidPoseError(f'{path} is not JSON: {error}; expected {example}') from None
    if not isinstance(content, dict):
        raise InvalidPoseError(f'{path} holds no object; expected {example}')
    unknown = sorted(set(content) - set(ROLES))
    if unknown:
        raise InvalidPoseError(f'{path}: unknown entry {unknown[0]!r}; expected base and relative')
    return content


def _pose(path: Path, content: dict[str, Any], role: str, example: str) -> Pose:
    import numpy as np

    from spatial_relations_ros.core import InvalidPoseError, Pose

    if role not in content:
        raise InvalidPoseError(f'{path}: the pose of {role!r} is missing; expected {example}')
    entry = content[role]
    if not isinstance(entry, dict):
        raise InvalidPoseError(
            f'{path}: {role} is {entry!r}; expected {{"t": ..., "q_wxyz": ...}}'
        )
    numbers = []
    for key, length in (('t', 3), ('q_wxyz', 4)):
        if key not in entry:
            raise InvalidPoseError(f'{path}: {role} lacks {key!r}; expected {example}')
        values = entry[key]
        if not isinstance(values, list) or len(values) != length or not _are_numbers(values):
            raise InvalidPoseError(
                f'{path}: {role}.{key} is {values!r}; expected {length} numbers'
            )
        numbers.append(values)
    unknown = sorted(set(entry) - {'t', 'q_wxyz'})
    if unknown:
        raise InvalidPoseError(f'{path}: {role} has an unknown entry {unknown[0]!r}')
    try:
        return Pose(np.array(numbers[0]), np.array(numbers[1]))
    except InvalidPoseError as error:
        raise InvalidPoseError(f'{path}: {role}: {error}') from None


def _are_numbers(values: list[Any]) -> bool:
    return all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
