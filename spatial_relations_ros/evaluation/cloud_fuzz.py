"""Feeds the PointCloud2 reader with messages of random layout and with hostile ones.

    python -m spatial_relations_ros.evaluation.cloud_fuzz --messages 100000

Each message must be read as a reader does that unpacks one number at a time, or be refused with
the reader's own exception.
"""

from __future__ import annotations

import argparse
import array
import struct
import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.progress import Progress

from spatial_relations_ros.core import CloudFormatError
from spatial_relations_ros.perception.point_cloud2 import read_xyz

# sensor_msgs/PointField: datatype constant -> code of the module struct.
STRUCT_CODES = {1: 'b', 2: 'B', 3: 'h', 4: 'H', 5: 'i', 6: 'I', 7: 'f', 8: 'd'}
FLOAT32 = 7
# Numbers at and beside the edges of what fits, and things that are no numbers.
HOSTILE_VALUES: tuple[Any, ...] = (
    -1, 0, 1, 2, 3, 7, 11, 12, 13, 16, 51, 53, 104, 2**16, 2**31, 2**32 - 1, 2**32, 2**63, 2**64,
    2**80, -(2**70), 1.5, float('nan'), float('inf'), None, '3', '', b'x', True, [], (), {},
    np.uint32(5), np.int64(-3), np.float32(2.0), object(),
)  # fmt: skip
MAX_FAILURES = 10


@dataclass
class FuzzedField:
    """As ``sensor_msgs/PointField``."""

    name: Any
    offset: Any
    datatype: Any = FLOAT32
    count: Any = 1


@dataclass
class FuzzedCloud:
    """As ``sensor_msgs/PointCloud2``, without its header."""

    height: Any
    width: Any
    fields: Any
    is_bigendian: Any
    point_step: Any
    row_step: Any
    data: Any
    is_dense: Any = True


@dataclass
class FuzzReport:
    """What became of the messages.

    Attributes:
        num_read: read as the naive reader does.
        num_refused: refused with the reader's own exception.
        failures: index and description of messages that were read wrongly, changed, or raised
            something else; the first of them.
        reasons: first words of the refusals, counted.
    """

    num_read: int = 0
    num_refused: int = 0
    failures: list[tuple[int, str]] = field(default_factory=list)
    reasons: Counter[str] = field(default_factory=Counter)


def random_cloud(rng: np.random.Generator) -> FuzzedCloud:
    """A valid message of random layout, byte order and container, filled with random bytes."""
    datatypes = rng.integers(1, 9, 3) if rng.random() < 0.7 else np.full(3, FLOAT32)
    fields, offset = [], 0
    for axis_idx in rng.permutation(3):
        offset += int(rng.integers(0, 6))
        datatype = int(datatypes[axis_idx])
        fields.append(FuzzedField('xyz'[axis_idx], offset, datatype, int(rng.integers(0, 2))))
        offset += struct.calcsize(STRUCT_CODES[datatype])
    if rng.random() < 0.5:
        fields.insert(int(rng.integers(0, 4)), FuzzedField('rgb', 0))
    point_step = offset + int(rng.integers(0, 10))
    height, width = int(rng.integers(0, 5)), int(rng.integers(0, 6))
    row_step = width * point_step + int(rng.integers(0, 8))
    content = rng.integers(0, 256, height * row_step + int(rng.integers(0, 4)), dtype=np.uint8)
    containers: tuple[Callable[[], Any], ...] = (
        content.tobytes,
        lambda: array.array('B', content.tobytes()),
        lambda: content,
        lambda: bytearray(content.tobytes()),
        lambda: np.repeat(content, 2)[::2],
        content.tolist,
    )
    return FuzzedCloud(
        height,
        width,
        fields,
        bool(rng.random() < 0.5),
        point_step,
        row_step,
        containers[rng.integers(len(containers))](),
        bool(rng.random() < 0.5),
    )


def damaged_cloud(rng: np.random.Generator) -> FuzzedCloud:
    """A message of random layout with one to three things replaced by hostile ones."""
    cloud = random_cloud(rng)
    for _ in range(rng.integers(1, 4)):
        value = HOSTILE_VALUES[rng.integers(len(HOSTILE_VALUES))]
        target = rng.integers(12)
        if target < 4:
            setattr(cloud, ('height', 'width', 'point_step', 'row_step')[target], value)
        elif target < 8 and isinstance(cloud.fields, list) and cloud.fields:
            some = cloud.fields[rng.integers(len(cloud.fields))]
            if isinstance(some, FuzzedField):
                setattr(some, ('offset', 'datatype', 'count', 'name')[target - 4], value)
        elif target == 8 and isinstance(cloud.data, (bytes, bytearray, array.array, np.ndarray)):
            cloud.data = cloud.data[: rng.integers(len(cloud.data) + 1)]
        elif target == 9 and isinstance(cloud.fields, list):
            del cloud.fields[rng.integers(5) :]
        elif target == 10:
            setattr(cloud, ('data', 'fields', 'is_bigendian')[rng.integers(3)], value)
        elif isinstance(cloud.fields, list):
            cloud.fields.insert(0, value)
    return cloud


def naive_xyz(cloud: Any) -> NDArray[np.float32]:
    """Coordinates (H, W, 3), each by its own unpack: slow, and plainly right."""
    order = '>' if cloud.is_bigendian else '<'
    by_name = {axis: next(f for f in cloud.fields if f.name == axis) for axis in 'xyz'}
    data = bytes(cloud.data)
    xyz = np.zeros((cloud.height, cloud.width, 3))
    for row in range(cloud.height):
        for column in range(cloud.width):
            start = row * cloud.row_step + column * cloud.point_step
            for axis_idx, axis in enumerate('xyz'):
                code = order + STRUCT_CODES[by_name[axis].datatype]
                place = start + by_name[axis].offset
                xyz[row, column, axis_idx] = struct.unpack_from(code, data, place)[0]
    with np.errstate(over='ignore', invalid='ignore'):
        return xyz.astype(np.float32)


def fuzz_reader(
    num_messages: int, *, seed: int = 0, on_message: Callable[[], None] | None = None
) -> FuzzReport:
    """Reads messages, every fourth of them valid.

    Args:
        num_messages: how many.
        seed: of the messages; each has a generator of its own, so that one can be made again.
        on_message: called after each.
    """
    report = FuzzReport()
    for idx in range(num_messages):
        rng = np.random.default_rng([seed, idx])
        is_valid = idx % 4 == 0
        cloud = random_cloud(rng) if is_valid else damaged_cloud(rng)
        num_refused = report.num_refused
        wrong = _check(cloud, report)
        if is_valid and report.num_refused > num_refused:
            wrong = 'a valid message was refused'
        if wrong is not None and len(report.failures) < MAX_FAILURES:
            report.failures.append((idx, f'{wrong}: {cloud}'))
        if on_message is not None:
            on_message()
    return report


def _check(cloud: FuzzedCloud, report: FuzzReport) -> str | None:
    """Reads one message; what is wrong with how it was read."""
    before = bytes(cloud.data) if isinstance(cloud.data, (bytearray, np.ndarray)) else None
    try:
        read = read_xyz(cloud)
    except CloudFormatError as error:
        report.num_refused += 1
        report.reasons[' '.join(str(error).split()[:2])] += 1
        return None
    except Exception as error:  # this is what is looked for
        return f'{type(error).__name__}: {error}'
    if before is not None and before != bytes(cloud.data):
        return 'the message was changed'
    if read.num_total:
        expected = naive_xyz(cloud)
        if not np.array_equal(read.xyz, expected, equal_nan=True):
            return f'read as {read.xyz.tolist()}, expected {expected.tolist()}'
        finite = np.isfinite(expected).all(axis=-1)
        if not np.array_equal(read.points, expected[finite]):
            return 'the finite points are not those of the message'
    report.num_read += 1
    return None


def main(arguments: Sequence[str] | None = None) -> int:
    """The command: see the module. Returns the exit code."""
    parser = argparse.ArgumentParser(description='Fuzzes the PointCloud2 reader.')
    parser.add_argument('--messages', type=int, default=100_000)
    parser.add_argument('--seed', type=int, default=0)
    args = parser.parse_args(arguments)
    start = time.perf_counter()
    with Progress(transient=True) as progress:
        task = progress.add_task('messages', total=args.messages)
        report = fuzz_reader(
            args.messages, seed=args.seed, on_message=lambda: progress.advance(task)
        )
    print(
        f'{args.messages} messages in {time.perf_counter() - start:.0f} s: {report.num_read} read '
        f'as the naive reader does, {report.num_refused} refused, {len(report.failures)} failures'
    )
    for reason, count in report.reasons.most_common(12):
        print(f'  {count} x {reason} ...')
    for idx, failure in report.failures:
        print(f'  message {idx}: {failure[:500]}')
    return 1 if report.failures else 0


if __name__ == '__main__':
    sys.exit(main())
