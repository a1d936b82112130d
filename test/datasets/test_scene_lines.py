"""The line formats of the dataset, with generated and real lines."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spatial_relations_ros.core import DatasetFormatError, Pose, Relation
from spatial_relations_ros.datasets.freiburg import (
    format_scene_line,
    parse_scene_line,
    read_labels,
    read_scene_lines,
)
from spatial_relations_ros.datasets.freiburg.lines import read_scene_names

moderate = settings(deadline=None, max_examples=50)
metres = st.floats(-2.0, 2.0, allow_nan=False)
names = st.from_regex(
    r'[A-Za-z][A-Za-z0-9]{0,12}_[A-Za-z][A-Za-z0-9]{0,12}_[0-9]{1,5}', fullmatch=True
)


@st.composite
def quaternions(draw) -> np.ndarray:
    values = np.array([draw(st.floats(-1.0, 1.0)) for _ in range(4)])
    norm = np.linalg.norm(values)
    return values / norm if norm > 1e-3 else np.array([1.0, 0.0, 0.0, 0.0])


@st.composite
def poses(draw) -> Pose:
    return Pose(np.array([draw(metres) for _ in range(3)]), draw(quaternions()))


@moderate
@given(names, quaternions(), poses())
def test_a_written_line_reads_back(name, base_quat, relative):
    base = Pose(np.zeros(3), base_quat)
    parsed = parse_scene_line(format_scene_line(name, base, relative))
    assert parsed.name == name
    assert parsed.world_from_base.is_close(base, metres=0.0, angle_rad=1e-6)
    assert parsed.world_from_relative.is_close(relative, metres=1e-8, angle_rad=1e-6)


@moderate
@given(poses(), poses())
def test_the_translation_is_taken_from_object_1(base, relative):
    parsed = parse_scene_line(format_scene_line('a_b_1', base, relative))
    np.testing.assert_array_equal(parsed.world_from_base.translation, 0.0)
    np.testing.assert_allclose(
        parsed.world_from_relative.translation,
        relative.translation - base.translation,
        atol=1e-8,
    )


@moderate
@given(
    names,
    poses(),
    st.sampled_from([';', ':', ' ; ', ' :  ']),
    st.sampled_from(['', ';', ' ;', ' ;  ', '\t;\r\n']),
    st.sampled_from([',', ', ', ' ,']),
)
def test_spaces_colons_and_ends_do_not_matter(name, pose, first, end, comma):
    line = name + first + comma.join(f'{v:.9g}' for v in pose.translation)
    line += ' ; ' + comma.join(f'{v:.9g}' for v in pose.quat_wxyz) + end
    parsed = parse_scene_line(line)
    assert parsed.world_from_relative.is_close(pose, metres=1e-8, angle_rad=1e-6)
    assert parsed.world_from_base.is_close(Pose.identity())


@moderate
@given(st.text(max_size=80))
def test_any_text_gives_a_scene_or_a_named_error(text):
    try:
        parsed = parse_scene_line(text, where='scenes.txt:7')
    except DatasetFormatError as error:
        complaint = str(error)
    else:
        complaint = ''
        assert np.isfinite(parsed.world_from_relative.as_matrix()).all()
    assert not complaint or complaint.startswith('scenes.txt:7: ')


@pytest.mark.parametrize(
    ('line', 'complaint'),
    [
        ('a_b_1;0,0,0', 'expected name;'),
        ('a_b_1;0,0,0;1,0,0,0;1,0,0,0;1', 'expected name;'),
        ('ab1;0,0,0;1,0,0,0', 'object1_object2_number'),
        ('a_b_c;0,0,0;1,0,0,0', 'object1_object2_number'),
        ('a_b_1;0,0;1,0,0,0', 'needs 3 numbers, got 2'),
        ('a_b_1;0,0,0;1,0,0', 'needs 4 numbers, got 3'),
        ('a_b_1;0,x,0;1,0,0,0', 'not made of numbers'),
        ('a_b_1;0,nan,0;1,0,0,0', 'not finite'),
        ('a_b_1;0,inf,0;1,0,0,0', 'not finite'),
        ('a_b_1;0,0,0;0,0,0,0', 'norm 0'),
        ('a_b_1;0,0,0;2,0,0,0', 'norm 2'),
        ('a_b_1;0,0,0;1,0,0,0;0,0,0,0', 'norm 0'),
    ],
)
def test_malformed_lines_say_where_and_what(line, complaint, tmp_path):
    path = tmp_path / 'scenes.txt'
    path.write_text(f'header\na_b_0;0,0,0;1,0,0,0;\n{line}\n')
    with pytest.raises(DatasetFormatError, match=complaint) as caught:
        read_scene_lines(path)
    assert f'{path}:3' in str(caught.value)


def test_repeated_and_absent_scenes(tmp_path):
    path = tmp_path / 'scenes.txt'
    path.write_text('a_b_0;0,0,0;1,0,0,0\n\na_b_0;0,0,1;1,0,0,0\n')
    with pytest.raises(DatasetFormatError, match=r':3: scene a_b_0 is also on line 1'):
        read_scene_lines(path)
    path.write_text('name;t;q\n')
    with pytest.raises(DatasetFormatError, match='no scenes'):
        read_scene_lines(path)
    path.write_bytes(b'\xff\xfe\x00')
    with pytest.raises(DatasetFormatError, match='read as text'):
        read_scene_lines(path)
    with pytest.raises(DatasetFormatError, match='does not exist'):
        read_scene_lines(tmp_path / 'other.txt')


def test_labels(tmp_path):
    path = tmp_path / 'labels.tsv'
    path.write_text('scene\tlabel\na_b_0\t3\na_c_1\t6\n\n')
    assert read_labels(path) == {'a_b_0': Relation.INCLINED, 'a_c_1': Relation.INSIDE_INCLINED}
    for text, complaint in [
        ('a_b_0\t7\n', r":2: label '7' is unknown.*0 on top"),
        ('a_b_0\tontop\n', r":2: label 'ontop' is unknown"),
        ('a_b_0\n', ':2: expected a scene name'),
        ('a_b_0\t1\na_b_0\t2\n', ':3: a_b_0 has a second label'),
    ]:
        path.write_text('scene\tlabel\n' + text)
        with pytest.raises(DatasetFormatError, match=complaint):
            read_labels(path)


def test_split_files(tmp_path):
    path = tmp_path / 'split1_train.txt'
    path.write_text('a_b_0\n\n# remark\na_c_1  \n')
    assert read_scene_names(path) == [(1, 'a_b_0'), (4, 'a_c_1')]
    path.write_text('\n')
    with pytest.raises(DatasetFormatError, match='split is empty'):
        read_scene_names(path)


@pytest.mark.shared_data
def test_the_real_scenes_are_read(shared_data):
    scenes = read_scene_lines(shared_data / 'freiburg' / 'simtrack_with_unit_gravity.txt')
    assert len(scenes) == 546
    unturned = [s.world_from_base.quat_wxyz[0] == 1.0 for s in scenes]
    assert sum(unturned) == 420
    first = scenes[0]
    assert first.name == 'tea1_tea2_0'
    np.testing.assert_allclose(
        first.world_from_relative.translation, [-0.011441, 0.00382207, 0.0742786]
    )
    np.testing.assert_allclose(
        first.world_from_relative.quat_wxyz,
        [0.998728, 0.0114389, -0.0464547, -0.015916],
        atol=5e-4,
    )
