"""Checking a pcd file's header against its length, before a library reads it.

Open3D takes a damaged header at its word: it may reserve any amount of memory, or return points
that are not in the file.
"""

from __future__ import annotations

import math
from pathlib import Path

from spatial_relations_ros.core import CloudFormatError

_LONGEST_HEADER = 8192
_NEEDED = ('FIELDS', 'SIZE', 'TYPE', 'WIDTH', 'HEIGHT', 'POINTS', 'DATA')
_ENCODINGS = ('ascii', 'binary', 'binary_compressed')


def check_pcd_header(path: Path) -> None:
    """Refuses a pcd file whose header is damaged, or longer than the file allows.

    Raises:
        CloudFormatError: with the line of the header, where there is one to blame.
    """
    with open(path, 'rb') as file:
        start = file.read(_LONGEST_HEADER)
    entries, length = _entries(path, start)
    for key in _NEEDED:
        if key not in entries:
            raise CloudFormatError(f'{path}: the header has no line {key}; is the file cut off?')
    if not {'x', 'y', 'z'} <= set(_words(entries, 'FIELDS')):
        raise CloudFormatError(f'{path}: {_at(entries, "FIELDS")}, fields x, y and z are needed')
    num_points = _numbers(path, entries, 'POINTS', 1)[0]
    width, height = (_numbers(path, entries, key, 1)[0] for key in ('WIDTH', 'HEIGHT'))
    if num_points != width * height:
        raise CloudFormatError(
            f'{path}: {_at(entries, "POINTS")}, but width {width} times height {height} is '
            f'{width * height}'
        )
    num_fields = len(_words(entries, 'FIELDS'))
    sizes = _numbers(path, entries, 'SIZE', num_fields)
    counts = (
        _numbers(path, entries, 'COUNT', num_fields) if 'COUNT' in entries else [1] * len(sizes)
    )
    point_step = sum(size * count for size, count in zip(sizes, counts, strict=True))
    _check_length(path, entries, length, num_points=num_points, point_step=point_step)


Entries = dict[str, tuple[int, str]]


def _entries(path: Path, start: bytes) -> tuple[Entries, int]:
    """Header lines by their key, with line numbers, and the header's length in bytes."""
    entries: Entries = {}
    length = 0
    for number, line in enumerate(start.splitlines(keepends=True), start=1):
        length += len(line)
        text = line.decode('ascii', errors='replace').strip()
        key, _, value = text.partition(' ')
        if not text or text.startswith('#'):
            continue
        entries[key.upper()] = (number, value.strip())
        if key.upper() == 'DATA':
            return entries, length
        if not key.isascii() or not key.isalpha():
            raise CloudFormatError(f'{path}:{number}: {text[:40]!r} is no line of a pcd header')
    return entries, length


def _check_length(
    path: Path, entries: Entries, header: int, *, num_points: int, point_step: int
) -> None:
    encoding = entries['DATA'][1]
    if encoding not in _ENCODINGS:
        raise CloudFormatError(
            f'{path}: {_at(entries, "DATA")}, it must be one of {", ".join(_ENCODINGS)}'
        )
    present = path.stat().st_size - header
    if encoding == 'binary':
        least = num_points * point_step
    elif encoding == 'ascii':
        # A digit and a separator for each of three coordinates; the last line may lack its end.
        least = 6 * num_points - 1
    else:
        least = 8 + math.ceil(num_points * point_step / 300)
    if present < least:
        raise CloudFormatError(
            f'{path}: {num_points} points need at least {least} bytes after the header, '
            f'{present} are there; the file is cut off'
        )


def _words(entries: Entries, key: str) -> list[str]:
    return entries[key][1].split()


def _numbers(path: Path, entries: Entries, key: str, count: int) -> list[int]:
    words = _words(entries, key)
    if len(words) != count or not all(word.isdigit() for word in words):
        raise CloudFormatError(
            f'{path}: {_at(entries, key)}, expected {count} whole number{"s" * (count > 1)}'
        )
    return [int(word) for word in words]


def _at(entries: Entries, key: str) -> str:
    number, value = entries[key]
    return f'line {number} of the header is {f"{key} {value}".strip()!r}'
