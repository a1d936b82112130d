"""Lines of ``scenes.txt``, ``labels.tsv`` and split files."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import DatasetFormatError, InvalidPoseError, Pose, Relation

_SEPARATOR = re.compile(r'[;:]')
_SCENE_NAME = re.compile(r'\S+_\S+_\d+')
_UNCHANGED = Pose.identity()
_FARTHEST = 1e4


@dataclass(frozen=True, eq=False)
class SceneLine:
    """A parsed line; the world's origin is object 1's, z is up.

    Attributes:
        name: ``object1_object2_number``.
        world_from_base: rotation only.
        world_from_relative: rotation and translation.
        line_number: in its file, from 1.
    """

    name: str
    world_from_base: Pose
    world_from_relative: Pose
    line_number: int = 0


def parse_scene_line(line: str, *, where: str = 'line', line_number: int = 0) -> SceneLine:
    """Reads ``name;tx,ty,tz;qw,qx,qy,qz[;qw,qx,qy,qz of object 1]``.

    A colon after the name, spaces and semicolons at the end are accepted; quaternions are
    normalised.

    Raises:
        DatasetFormatError: with ``where`` in front, for anything else.
    """
    fields = [part.strip() for part in _SEPARATOR.split(line.strip())]
    while fields and not fields[-1]:
        fields.pop()
    if len(fields) not in (3, 4):
        raise DatasetFormatError(
            f'{where}: expected name;tx,ty,tz;qw,qx,qy,qz[;q of object 1], got {line.strip()!r}'
        )
    name = fields[0]
    if not _SCENE_NAME.fullmatch(name):
        raise DatasetFormatError(
            f'{where}: scene name {name!r} is not of the form object1_object2_number'
        )
    translation = _numbers(fields[1], 3, 'translation', where)
    if np.isfinite(translation).all() and (np.abs(translation) > _FARTHEST).any():
        raise DatasetFormatError(
            f'{where}: translation {fields[1]!r} is farther than {_FARTHEST:g} from object 1'
        )
    quat_relative = _numbers(fields[2], 4, 'quaternion of object 2', where)
    try:
        world_from_relative = Pose(translation, quat_relative)
        world_from_base = (
            Pose(np.zeros(3), _numbers(fields[3], 4, 'quaternion of object 1', where))
            if len(fields) == 4
            else _UNCHANGED
        )
    except InvalidPoseError as error:
        raise DatasetFormatError(f'{where}: {error}') from error
    return SceneLine(name, world_from_base, world_from_relative, line_number)


def _numbers(text: str, count: int, what: str, where: str) -> NDArray[np.float64]:
    parts = [part for part in re.split(r'[,\s]+', text) if part]
    try:
        values = [float(part) for part in parts]
    except ValueError:
        raise DatasetFormatError(f'{where}: {what} {text!r} is not made of numbers') from None
    if len(values) != count:
        raise DatasetFormatError(
            f'{where}: {what} needs {count} numbers, got {len(values)} ({text!r})'
        )
    return np.array(values)


def format_scene_line(name: str, world_from_base: Pose, world_from_relative: Pose) -> str:
    """The line of a scene; the translation is taken relative to object 1."""
    translation = world_from_relative.translation - world_from_base.translation
    fields = [name, _text(translation), _text(world_from_relative.quat_wxyz)]
    # The last field stays empty, not absent, when object 1 is not turned: the authors' reader
    # expects four fields.
    is_turned = abs(world_from_base.quat_wxyz[0]) < 1.0 - 1e-12
    fields.append(_text(world_from_base.quat_wxyz) if is_turned else '')
    return ';'.join(fields)


def _text(values: NDArray[np.float64]) -> str:
    # Adding zero turns -0.0 into 0.0.
    return ','.join(f'{float(value) + 0.0:.9g}' for value in values)


def read_scene_lines(path: Path) -> list[SceneLine]:
    """Reads a file of scenes; a header line, empty lines and ``#`` comments are skipped.

    Raises:
        DatasetFormatError: with file and line, for malformed lines, repeated names, no scenes.
    """
    scenes: list[SceneLine] = []
    first_seen: dict[str, int] = {}
    for number, line in enumerate(read_lines(path), start=1):
        text = line.strip()
        is_header = number == 1 and not re.search(r'_\d+\s*[;:]', text)
        if not text or text.startswith('#') or is_header:
            continue
        scene = parse_scene_line(text, where=f'{path}:{number}', line_number=number)
        if scene.name in first_seen:
            raise DatasetFormatError(
                f'{path}:{number}: scene {scene.name} is also on line {first_seen[scene.name]}'
            )
        first_seen[scene.name] = number
        scenes.append(scene)
    if not scenes:
        raise DatasetFormatError(f'{path}: holds no scenes')
    return scenes


def read_labels(path: Path) -> dict[str, Relation]:
    """Reads ``scene<tab>label`` lines after one header line.

    Raises:
        DatasetFormatError: with file and line, for malformed lines and unknown labels.
    """
    labels: dict[str, Relation] = {}
    for number, line in enumerate(read_lines(path), start=1):
        fields = line.split()
        if not fields or (number == 1 and _is_header(fields)):
            continue
        if len(fields) < 2:
            raise DatasetFormatError(
                f'{path}:{number}: expected a scene name, a tab and a label, got {line.strip()!r}'
            )
        try:
            label = Relation(int(fields[1]))
        except ValueError:
            known = ', '.join(f'{int(r)} {r.description}' for r in Relation)
            raise DatasetFormatError(
                f'{path}:{number}: label {fields[1]!r} is unknown; labels are {known}'
            ) from None
        if labels.setdefault(fields[0], label) is not label:
            raise DatasetFormatError(f'{path}:{number}: {fields[0]} has a second label')
    return labels


def _is_header(fields: list[str]) -> bool:
    """Whether the first line of a label file names columns rather than a scene."""
    return not fields[-1].lstrip('-').isdigit() and not _SCENE_NAME.fullmatch(fields[0])


def read_scene_names(path: Path) -> list[tuple[int, str]]:
    """Line numbers and scene names of a split file: the first word of each line.

    Raises:
        DatasetFormatError: when there are none.
    """
    names = [
        (number, re.split(r'[\s;,]+', line.strip())[0])
        for number, line in enumerate(read_lines(path), start=1)
        if line.strip() and not line.lstrip().startswith('#')
    ]
    if not names:
        raise DatasetFormatError(f'{path}: the split is empty')
    return names


def read_json(path: Path) -> dict[str, Any]:
    """A JSON object.

    Raises:
        DatasetFormatError: when the file is missing or is none.
    """
    try:
        content = json.loads('\n'.join(read_lines(path)))
    except ValueError as error:
        raise DatasetFormatError(f'{path} is not JSON: {error}') from error
    if not isinstance(content, dict):
        raise DatasetFormatError(f'{path} holds no JSON object')
    return content


def read_lines(path: Path) -> list[str]:
    """Lines of a text file.

    Raises:
        DatasetFormatError: when it is missing or is not text.
    """
    try:
        return path.read_text(encoding='utf-8').splitlines()
    except FileNotFoundError:
        raise DatasetFormatError(f'{path} does not exist') from None
    except (UnicodeDecodeError, OSError) as error:
        raise DatasetFormatError(f'{path} cannot be read as text: {error}') from error
