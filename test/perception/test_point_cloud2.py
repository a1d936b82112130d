"""The PointCloud2 reader against a reader that unpacks one number at a time."""

import array
import math
import struct
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spatial_relations_ros.core import CloudFormatError
from spatial_relations_ros.evaluation import cloud_fuzz
from spatial_relations_ros.evaluation.cloud_fuzz import STRUCT_CODES, fuzz_reader, naive_xyz
from spatial_relations_ros.perception.point_cloud2 import PointCloud, read_xyz

FLOAT32, FLOAT64 = 7, 8


def field(name, offset, datatype=FLOAT32, count=1):
    return SimpleNamespace(name=name, offset=offset, datatype=datatype, count=count)


def message(**changes):
    """A cloud of 2 x 3 points, x y z in 16 bytes, with a row padding of 4 bytes."""
    xyz = np.arange(18, dtype='<f4').reshape(2, 3, 3)
    rows = np.zeros((2, 3, 4), dtype='<f4')
    rows[..., :3] = xyz
    padded = b''.join(row.tobytes() + b'\xff' * 4 for row in rows)
    fields = {
        'height': 2,
        'width': 3,
        'fields': [field('x', 0), field('y', 4), field('z', 8)],
        'is_bigendian': False,
        'point_step': 16,
        'row_step': 52,
        'data': padded,
        'is_dense': True,
    }
    return SimpleNamespace(**(fields | changes))


@st.composite
def clouds(draw):
    """Clouds of every layout that the message allows, filled with arbitrary bytes."""
    datatypes = draw(st.lists(st.integers(1, 8), min_size=3, max_size=3))
    if draw(st.booleans()):
        datatypes = [FLOAT32] * 3
    fields, offset = [], 0
    for axis_idx in draw(st.permutations(range(3))):
        offset += draw(st.integers(0, 5))
        fields.append(field('xyz'[axis_idx], offset, datatypes[axis_idx], draw(st.integers(0, 1))))
        offset += struct.calcsize(STRUCT_CODES[datatypes[axis_idx]])
    if draw(st.booleans()):
        fields.insert(draw(st.integers(0, 3)), field('rgb', 0))
    point_step = offset + draw(st.integers(0, 9))
    height, width = draw(st.integers(0, 4)), draw(st.integers(0, 5))
    row_step = width * point_step + draw(st.integers(0, 7))
    num_bytes = height * row_step + draw(st.integers(0, 3))
    seed = draw(st.integers(0, 2**32 - 1))
    data = np.random.default_rng(seed).integers(0, 256, num_bytes, dtype=np.uint8)
    container = draw(st.sampled_from(['bytes', 'array', 'numpy', 'bytearray', 'strided']))
    containers = {
        'bytes': data.tobytes(),
        'array': array.array('B', data.tobytes()),
        'numpy': data,
        'bytearray': bytearray(data.tobytes()),
        'strided': np.repeat(data, 2)[::2],
    }
    return SimpleNamespace(
        height=height,
        width=width,
        fields=fields,
        is_bigendian=draw(st.booleans()),
        point_step=point_step,
        row_step=row_step,
        data=containers[container],
        is_dense=draw(st.booleans()),
    )


@settings(max_examples=300, deadline=None)
@given(clouds())
def test_equals_the_naive_reader(cloud):
    before = bytes(cloud.data)
    read = read_xyz(cloud)
    expected = naive_xyz(cloud)
    if expected.size:
        np.testing.assert_array_equal(read.xyz, expected)
    finite = [p for p in expected.reshape(-1, 3).tolist() if all(map(math.isfinite, p))]
    np.testing.assert_array_equal(read.points, np.array(finite, dtype='f4').reshape(-1, 3))
    assert read.num_finite == len(finite)
    assert bytes(cloud.data) == before


def test_fuzzed_messages_are_read_rightly_or_refused():
    """``python -m spatial_relations_ros.evaluation.cloud_fuzz`` takes more."""
    report = fuzz_reader(5000, seed=7)
    assert report.failures == []
    assert report.num_read > 1250
    assert report.num_refused > 2000
    assert report.num_read + report.num_refused == 5000


def test_the_fuzzer_notices_wrong_readers(monkeypatch):
    def shifted(cloud):
        return PointCloud(read_xyz(cloud).xyz + np.float32(1.0))

    def raising(cloud):
        raise IndexError('out of range')

    for wrong, words in ((shifted, 'expected'), (raising, 'IndexError: out of range')):
        monkeypatch.setattr(cloud_fuzz, 'read_xyz', wrong)
        report = fuzz_reader(40)
        assert report.failures
        assert words in report.failures[0][1]


def test_keeps_rows_and_columns_and_copies_nothing():
    data = array.array('B', message().data)
    read = read_xyz(message(data=data))
    np.testing.assert_array_equal(read.xyz, np.arange(18).reshape(2, 3, 3))
    assert read.is_organised
    assert np.shares_memory(read.xyz, np.frombuffer(data, dtype=np.uint8))
    assert not read.xyz.flags.writeable


def test_filters_nan_and_infinity_although_the_cloud_claims_to_be_dense():
    xyz = np.zeros((1, 4, 3), dtype='<f4')
    xyz[0, 1, 0], xyz[0, 2, 1], xyz[0, 3, 2] = np.nan, np.inf, -np.inf
    read = read_xyz(
        message(height=1, width=4, point_step=12, row_step=48, data=xyz.tobytes(), is_dense=True)
    )
    assert (read.num_total, read.num_finite) == (4, 1)
    np.testing.assert_array_equal(read.points, [[0, 0, 0]])


def test_one_finite_point_anywhere_is_enough_for_a_cloud():
    xyz = np.full((40, 50, 3), np.nan, dtype=np.float32)
    assert PointCloud(xyz).is_empty
    for row, column in ((0, 0), (39, 49), (17, 3)):
        seen = xyz.copy()
        seen[row, column] = 1.0
        assert not PointCloud(seen).is_empty
        assert PointCloud(seen).num_finite == 1
        window = PointCloud(seen).window(slice(row, 40), slice(column, 50))
        np.testing.assert_array_equal(window.points, [[1.0, 1.0, 1.0]])
    seen[:, :, 1] = np.inf
    assert PointCloud(seen).is_empty


def test_all_nan_is_an_empty_cloud_with_a_count():
    nan = np.full((2, 3, 4), np.nan, dtype='<f4')
    read = read_xyz(message(row_step=48, data=nan.tobytes()))
    assert (read.num_total, read.num_finite, len(read.points)) == (6, 0, 0)


def test_reads_big_endian_without_swapping_the_message():
    values = np.arange(24, dtype='>f4')
    data = bytearray(values.tobytes())
    read = read_xyz(message(is_bigendian=True, row_step=48, data=data))
    np.testing.assert_array_equal(read.xyz, values.reshape(2, 3, 4)[..., :3])
    assert data == values.tobytes()


def test_a_double_too_large_for_float32_is_not_finite():
    data = np.array([1e300, 0.0, 0.0]).astype('<f8').tobytes()
    fields = [field(axis, 8 * i, FLOAT64) for i, axis in enumerate('xyz')]
    cloud = message(height=1, width=1, fields=fields, point_step=24, row_step=24, data=data)
    assert read_xyz(cloud).num_finite == 0


@pytest.mark.parametrize(
    ('changes', 'reason'),
    [
        ({'row_step': 47}, r'row_step is 47 bytes.*at least 48'),
        ({'row_step': 53}, r'data has 104 bytes.*needs 106'),
        ({'row_step': 0}, r'row_step is 0'),
        ({'point_step': 0}, r'point_step is 0'),
        ({'point_step': 8}, r'field z has 4 bytes at offset 8, outside of point_step 8'),
        ({'fields': [field('x', 0), field('y', 4)]}, r'no field z; the cloud has x, y'),
        ({'fields': []}, r'no field x, y, z; the cloud has none'),
        ({'fields': [field('x', 0), field('y', 4), field('z', -4)]}, r'offset is -4'),
        ({'fields': [field('x', 0), field('y', 4), field('z', 8, 9)]}, r'datatype 9'),
        ({'fields': [field('x', 0), field('y', 4), field('z', 8, 7, 3)]}, r'count 3'),
        ({'fields': [field(a, 0) for a in 'xyzx']}, r'field x comes 2 times'),
        ({'data': b'\0' * 103}, r'data has 103 bytes'),
        ({'width': -1}, r'width is -1'),
        ({'width': 2**32 - 1}, r'row_step is 52 bytes'),
        ({'height': 2**32 - 1}, r'data has 104 bytes'),
        ({'height': 2**70}, r'height is'),
        ({'height': 1.5}, r'height is 1.5, expected an integer'),
        ({'data': [1, 2, 300]}, r'list, but not of bytes'),
        ({'data': np.zeros(26, dtype='<f4')}, r'items of 4 bytes'),
        ({'data': None}, r'data is NoneType'),
        ({'fields': None}, r'fields is no sequence of PointField'),
        ({'fields': ['x', 'y', 'z']}, r'fields is no sequence of PointField'),
    ],
)
def test_says_what_is_wrong(changes, reason):
    with pytest.raises(CloudFormatError, match=reason):
        read_xyz(message(**changes))


def test_decimation_is_a_view_of_every_nth_row_and_column():
    cloud = PointCloud(np.arange(6 * 8 * 3, dtype=np.float32).reshape(6, 8, 3))
    thin = cloud.decimated(2)
    np.testing.assert_array_equal(thin.xyz, cloud.xyz[::2, ::2])
    assert np.shares_memory(thin.xyz, cloud.xyz)
    assert PointCloud(cloud.xyz.reshape(-1, 3)).decimated(2).num_total == 12


def test_refuses_arrays_that_are_no_cloud():
    with pytest.raises(CloudFormatError, match=r'\(N, 3\), got \(4, 2\)'):
        PointCloud(np.zeros((4, 2), dtype=np.float32))
