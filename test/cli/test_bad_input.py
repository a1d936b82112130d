"""What a user does wrong ends with exit code 2 and a sentence, never with a traceback."""

import contextlib
import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spatial_relations_ros.cli.pose_files import read_pose_file
from spatial_relations_ros.core import InvalidPoseError

GOOD = {'t': [0, 0, 0.1], 'q_wxyz': [1, 0, 0, 0]}


@pytest.mark.parametrize(
    ('content', 'message'),
    [
        ('{', 'is not JSON'),
        ('[]', 'holds no object'),
        (json.dumps({'base': GOOD}), "pose of 'relative' is missing"),
        (json.dumps({'base': GOOD, 'relative': GOOD, 'third': GOOD}), "unknown entry 'third'"),
        (json.dumps({'base': GOOD, 'relative': [1]}), 'relative is'),
        (json.dumps({'base': GOOD, 'relative': {'t': [0, 0, 0]}}), "lacks 'q_wxyz'"),
        (json.dumps({'base': {**GOOD, 't': [0, 0]}, 'relative': GOOD}), 'expected 3 numbers'),
        (json.dumps({'base': {**GOOD, 't': [0, 0, '1']}, 'relative': GOOD}), 'expected 3'),
        (json.dumps({'base': {**GOOD, 't': [0, 0, True]}, 'relative': GOOD}), 'expected 3'),
        (json.dumps({'base': {**GOOD, 'q': 1}, 'relative': GOOD}), "unknown entry 'q'"),
        ('{"base": {"t": [0, 0, NaN], "q_wxyz": [1, 0, 0, 0]}, "relative": {}}', 'not finite'),
        (json.dumps({'base': {**GOOD, 'q_wxyz': [0, 0, 0, 0]}, 'relative': GOOD}), 'norm 0'),
        (json.dumps({'base': {**GOOD, 'q_wxyz': [1, 1, 0, 0]}, 'relative': GOOD}), 'unit'),
    ],
)
def test_pose_files_say_what_is_wrong(tmp_path, content, message):
    path = tmp_path / 'poses.json'
    path.write_text(content)
    with pytest.raises(InvalidPoseError, match=r'poses\.json') as caught:
        read_pose_file(path)
    assert message in str(caught.value)


def test_a_missing_pose_file(tmp_path):
    with pytest.raises(InvalidPoseError, match='cannot be read'):
        read_pose_file(tmp_path / 'none.json')


json_values = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(
            st.sampled_from(['base', 'relative', 't', 'q_wxyz', 'x']), inner, max_size=3
        )
    ),
    max_leaves=12,
)


@settings(max_examples=80, deadline=None)
@given(value=json_values)
def test_any_json_is_a_pose_or_a_named_error(tmp_path_factory, value):
    path = tmp_path_factory.mktemp('fuzz') / 'poses.json'
    path.write_text(json.dumps(value))
    with contextlib.suppress(InvalidPoseError):
        base, relative = read_pose_file(path)
        assert abs(sum(base.quat_wxyz**2) - 1.0) < 1e-9
        assert abs(sum(relative.quat_wxyz**2) - 1.0) < 1e-9


def test_scenes_must_be_named_once_and_wholly(relations, data, scene_files, weights):
    files = scene_files['reference']
    for arguments, message in (
        ([], 'name the scene once'),
        (['--scene', 'tray_cup_0'], 'needs --data'),
        (['--base', files.base], '--relative, --poses missing'),
        (['--scene', 'x', '--data', data, *files.options()], 'got 2 ways'),
    ):
        result = relations('embed', *arguments, '--weights', weights)
        assert result.exit_code == 2, result.output
        assert message in result.stderr


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (['embed', '--data', 'DATA', '--scene', 'none_0'], "no scene 'none_0'"),
        (['embed', '--data', 'nowhere', '--scene', 'a'], 'nowhere'),
        (
            ['embed', '--data', 'DATA', '--scene', 'tray_cup_0', '--weights', 'none.safetensors'],
            'none.safetensors does not exist',
        ),
        (['embed', '--base', 'a.xyz', '--relative', 'b.ply', '--poses', 'POSES'], 'a.xyz'),
        (['replay', 'nowhere'], 'nowhere'),
        (['train', 'DATA', '--out', 'weights.pt', '--steps', '1'], '.safetensors'),
        (['train', 'DATA', '--out', 'w.safetensors', '--config', 'x'], "no configuration 'x'"),
        (['generate', 'OUT', '--scenes', '3'], 'at least 28'),
        (['nonsense'], 'nonsense'),
    ],
)
def test_bad_input_exits_with_2(relations, data, scene_files, tmp_path, arguments, message):
    places = {'DATA': data, 'POSES': scene_files['test'].poses, 'OUT': tmp_path / 'out'}
    result = relations(*(places.get(argument, argument) for argument in arguments))
    assert result.exit_code == 2, result.output
    assert message in result.stderr
    assert 'Traceback' not in result.stderr
    assert not (tmp_path / 'out').exists()


def test_debug_shows_where_an_error_comes_from(relations, data):
    plain = relations('embed', '--data', data, '--scene', 'none_0')
    debugged = relations('embed', '--data', data, '--scene', 'none_0', '--debug')
    assert isinstance(plain.exception, SystemExit)
    assert type(debugged.exception).__name__ == 'DatasetFormatError'


def test_a_json_file_that_cannot_be_written_is_refused_before_the_work(relations, tmp_path, data):
    result = relations('embed', '--data', data, '--scene', 'x', '--json', tmp_path)
    assert result.exit_code == 2
    assert 'is a folder' in result.stderr


@pytest.mark.parametrize(
    'arguments',
    [
        ['train', 'DATA', '--out', 'FILE/w.safetensors', '--steps', '1'],
        ['train', 'DATA', '--out', 'w.safetensors', '--run-dir', 'FILE', '--steps', '1'],
        ['imitate', '--out', 'FILE'],
        ['imitate', '--report', 'FILE/report.html'],
        ['imitate', '--animation', 'FILE/way.gif'],
        ['imitate', '--json', 'FILE/x.json'],
        ['retrieve', 'DATA', '--markdown', 'FILE/table.md'],
        ['retrieve', 'DATA', '--pictures', 'FILE/pictures'],
        ['generalize', 'DATA', '--pictures', 'FILE'],
        ['replay', 'nowhere', '--csv', 'FILE/rows.csv'],
    ],
)
def test_places_that_cannot_be_written_are_refused_before_the_work(
    relations, data, tmp_path, arguments
):
    file = tmp_path / 'file'
    file.write_text('not a folder')
    words = (argument.replace('FILE', str(file)) for argument in arguments)
    result = relations(*(data if word == 'DATA' else word for word in words))
    assert result.exit_code == 2, result.output
    assert 'is a file, not a folder' in ' '.join(result.stderr.split())


def test_options_that_would_be_ignored_are_refused(relations, data, scene_files, weights):
    files = [
        option for role in ('reference', 'test') for option in scene_files[role].options(role)
    ]
    for option, value in (('--data', data), ('--memory', 'relations.sqlite3')):
        result = relations('imitate', *files, option, value, '--weights', weights)
        assert result.exit_code == 2, result.output
        assert f'{option} goes with' in result.stderr


def test_units_that_look_wrong_are_warned_about(relations, scene_files, weights, tmp_path):
    huge = tmp_path / 'huge.off'
    huge.write_text('OFF\n4 2 0\n0 0 0\n100 0 0\n0 100 0\n0 0 100\n3 0 1 2\n3 0 2 3\n')
    files = scene_files['test']
    result = relations(
        'embed', '--base', huge, '--relative', files.relative, '--poses', files.poses,
        '--weights', weights,
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    assert 'millimetres?' in result.stderr
    assert '.py:' not in result.stderr


def test_a_file_is_no_folder_for_a_dataset(relations, tmp_path):
    (tmp_path / 'file').write_text('')
    result = relations('generate', tmp_path / 'file', '--scenes', 28, '--objects', 10)
    assert result.exit_code == 2
    assert 'is a file, not a folder' in ' '.join(result.stderr.split())


@pytest.mark.parametrize('seed', [-1, 2**32])
def test_seeds_that_not_everything_takes_are_refused(relations, tmp_path, seed):
    result = relations('generate', tmp_path / 'data', '--seed', seed)
    assert result.exit_code == 2
    assert '--seed' in result.stderr
