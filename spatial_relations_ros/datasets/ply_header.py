"""Checking a ply file's header against its length, before a library reads it.

Open3D reads a file that is cut off as far as it goes, and calls what it got the whole.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from spatial_relations_ros.core import CloudFormatError

_LONGEST_HEADER = 65536
_SIZES = {
    'char': 1, 'uchar': 1, 'int8': 1, 'uint8': 1,
    'short': 2, 'ushort': 2, 'int16': 2, 'uint16': 2,
    'int': 4, 'uint': 4, 'int32': 4, 'uint32': 4, 'float': 4, 'float32': 4,
    'double': 8, 'float64': 8,
}  # fmt: skip
_FORMATS = ('ascii', 'binary_little_endian', 'binary_big_endian')
_LEAST_CORNERS = 3
_BLOCK = 1 << 20


@dataclass
class _Element:
    """What the header says of vertices, faces or others: how many, and bytes of each at least."""

    name: str
    count: int
    least_size: int = field(default=0)


def check_ply_header(path: Path) -> None:
    """Refuses a ply file whose header is damaged, or promises more than the file holds.

    Raises:
        CloudFormatError: with the line of the header, where there is one to blame.
    """
    with open(path, 'rb') as file:
        start = file.read(_LONGEST_HEADER)
    encoding, elements, length = _read(path, start)
    if encoding == 'ascii':
        needed, unit = sum(element.count for element in elements), 'lines'
        present = _num_lines(path, length)
    else:
        needed = sum(element.count * element.least_size for element in elements)
        unit, present = 'bytes', path.stat().st_size - length
    if present < needed:
        listed = ', '.join(f'{element.count} {element.name}' for element in elements)
        raise CloudFormatError(
            f'{path}: its elements ({listed}) need at least {needed} {unit} after the header, '
            f'{present} are there; the file is cut off'
        )


def _read(path: Path, start: bytes) -> tuple[str, list[_Element], int]:
    """The format, the elements, and the header's length in bytes."""
    encoding, length = '', 0
    elements: list[_Element] = []
    for number, line in enumerate(start.splitlines(keepends=True), start=1):
        length += len(line)
        words = line.decode('ascii', errors='replace').split()
        match words:
            case ['end_header']:
                if not encoding:
                    raise CloudFormatError(f'{path}: the header has no format')
                return encoding, elements, length
            case ['ply'] if number == 1:
                continue
            case ['format', name, _] if name in _FORMATS:
                encoding = name
            case ['element', name, count] if count.isdigit():
                elements.append(_Element(name, int(count)))
            case ['property', 'list', size, item, _] if elements and {size, item} <= set(_SIZES):
                corners = _LEAST_CORNERS if elements[-1].name == 'face' else 0
                elements[-1].least_size += _SIZES[size] + corners * _SIZES[item]
            case ['property', kind, _] if elements and kind in _SIZES:
                elements[-1].least_size += _SIZES[kind]
            case ['comment' | 'obj_info', *_] | []:
                continue
            case _:
                text = line.decode('ascii', errors='replace').strip()
                raise CloudFormatError(
                    f'{path}:{number}: {text[:40]!r} is no line of a ply header'
                )
    raise CloudFormatError(f'{path}: the header has no end; is the file cut off?')


def _num_lines(path: Path, skipped: int) -> int:
    """Lines with anything in them after so many bytes."""
    count, rest = 0, b''
    with open(path, 'rb') as file:
        file.seek(skipped)
        while block := file.read(_BLOCK):
            *lines, rest = (rest + block).split(b'\n')
            count += sum(1 for line in lines if line.strip())
    return count + bool(rest.strip())
