import json

import pytest

from spatial_relations_ros.visualization import read_image

POSE = {'t': [float] * 3, 'q_wxyz': [float] * 4}
TARGET = {
    'approach': POSE,
    'approach_clear': bool,
    'reachable': bool,
    'gripper': type(None),
    'gripper_approach': type(None),
}
IMITATION_SCHEMA = {
    'answers': [
        {
            'poses': {'base': POSE, 'relative': POSE},
            'distance': float,
            'feasible': bool,
            'violations': [str],
            'order': [{'role': str, 'to': str}],
            'targets': {'base': TARGET, 'relative': TARGET},
        }
    ],
    'initial_distance': float,
    'duration': float,
    'steps': int,
}


def assert_fits(value, schema, path='result'):
    """The value has exactly the schema's keys and types; lists repeat their only entry."""
    if isinstance(schema, dict):
        assert isinstance(value, dict), path
        assert list(value) == list(schema), path
        for key, part in schema.items():
            assert_fits(value[key], part, f'{path}.{key}')
    elif isinstance(schema, list):
        assert isinstance(value, list), path
        if len(schema) > 1:
            assert len(value) == len(schema), path
        for idx, item in enumerate(value):
            assert_fits(item, schema[0], f'{path}[{idx}]')
    else:
        assert type(value) is schema, f'{path}: {value!r}'


def test_the_same_seed_gives_the_same_bytes_but_for_the_time(tmp_path, scene_files, weights):
    from typer.testing import CliRunner

    from spatial_relations_ros.cli.main import app

    def answered(name, seed):
        path = tmp_path / name
        arguments = [
            'imitate', *scene_files['reference'].options('reference'),
            *scene_files['test'].options('test'), '--weights', str(weights), '--steps', '2',
            '--proposals', '24', '--seed', seed, '--json', str(path),
        ]  # fmt: skip
        CliRunner().invoke(app, arguments)
        lines = path.read_text().splitlines()
        return [line for line in lines if '"duration"' not in line]

    first = answered('first.json', '3')
    assert len(first) > 20
    assert first == answered('again.json', '3')
    assert first != answered('other.json', '4')


def test_the_schema_check_can_fail():
    for wrong in ({'a': 1, 'b': 2}, {}, {'a': 1.5}):
        with pytest.raises(AssertionError):
            assert_fits(wrong, {'a': int})


@pytest.fixture(scope='module')
def imitated(tmp_path_factory, scene_files, weights):
    """One run of imitate with all its outputs."""
    from typer.testing import CliRunner

    from spatial_relations_ros.cli.main import app

    folder = tmp_path_factory.mktemp('imitated')
    arguments = [
        'imitate', *scene_files['reference'].options('reference'),
        *scene_files['test'].options('test'), '--weights', str(weights), '--steps', '2',
        '--out', str(folder / 'out'), '--json', str(folder / 'deep' / 'result.json'),
    ]  # fmt: skip
    return CliRunner().invoke(app, arguments), folder


def test_imitate_writes_the_documented_json(imitated):
    result, folder = imitated
    content = json.loads((folder / 'deep' / 'result.json').read_text())
    assert_fits(content, IMITATION_SCHEMA)
    assert content['answers'], result.output
    assert json.loads((folder / 'out' / 'result.json').read_text()) == content


def test_imitate_moves_the_relative_alone(imitated):
    _, folder = imitated
    content = json.loads((folder / 'deep' / 'result.json').read_text())
    poses = content['answers'][0]['poses']
    assert poses['base']['t'] == pytest.approx([0.0, 0.0, 0.03], abs=1e-6)
    assert poses['base']['q_wxyz'] == pytest.approx([1.0, 0.0, 0.0, 0.0], abs=1e-6)
    norm = sum(value**2 for value in poses['relative']['q_wxyz'])
    assert norm == pytest.approx(1.0, abs=1e-6)


def test_imitate_exits_by_its_success(imitated):
    result, folder = imitated
    content = json.loads((folder / 'deep' / 'result.json').read_text())
    best = content['answers'][0]
    assert result.exit_code in (0, 1), result.output
    assert ('not imitated' in result.output) == (result.exit_code == 1)
    if result.exit_code == 0:
        assert best['feasible']


def test_imitate_leaves_pictures(imitated):
    _, folder = imitated
    names = {path.name for path in (folder / 'out').glob('*.png')}
    assert {'overview.png', 'reference.png', 'test_before.png', 'test_after.png'} <= names
    assert {'distance.png', 'test_after_projections.png'} <= names
    assert read_image(folder / 'out' / 'overview.png').std() > 5.0


def test_distance_knows_itself(relations, data, weights, tmp_path):
    out = tmp_path / 'distance.json'
    for test, is_same in (('tray_cup_0', True), ('carton_can_0', False)):
        result = relations(
            'distance', '--data', data, '--reference', 'tray_cup_0', '--test', test,
            '--weights', weights, '--json', out,
        )  # fmt: skip
        assert result.exit_code == 0, result.output
        content = json.loads(out.read_text())
        assert (content['distance'] < 1e-3) == is_same
        assert len(content['model_hash']) == 64


def test_distance_says_what_it_means(relations, data, weights, calibrated_weights):
    arguments = [
        'distance', '--data', data, '--reference', 'tray_cup_0', '--test', 'carton_can_0',
        '--json', '-', '--weights',
    ]  # fmt: skip
    plain = relations(*arguments, weights)
    content = json.loads(plain.stdout)
    assert 'no calibration' in plain.stderr
    assert content['same_relation_probability'] is content['same_relation_distance'] is None
    assert content['reference'] == content['test'] == {'novelty': None, 'is_novel': None}
    known = relations(*arguments, calibrated_weights)
    again = json.loads(known.stdout)
    assert again['distance'] == content['distance']
    assert again['same_relation_probability'] == pytest.approx(0.9 - 0.4 * content['distance'])
    assert again['same_relation_distance'] == pytest.approx(1.0)
    for role in ('reference', 'test'):
        assert again[role]['is_novel']
        assert again[role]['novelty'] > 10.0
        assert f'{role}: novel' in known.stderr
    embedded = relations('embed', '--data', data, '--scene', 'tray_cup_0', '--json', '-',
                         '--weights', calibrated_weights)  # fmt: skip
    assert json.loads(embedded.stdout)['novelty'] == pytest.approx(again['reference']['novelty'])


def test_embed_by_files_equals_the_metric(relations, scene_files, weights):
    from spatial_relations_ros.cli.scene_sources import SceneSource
    from spatial_relations_ros.learning import load_metric

    files = scene_files['reference']
    result = relations('embed', *files.options(), '--weights', weights, '--json', '-')
    assert result.exit_code == 0, result.output
    content = json.loads(result.stdout)
    scene = SceneSource(
        '', base=_path(files.base), relative=_path(files.relative), poses=_path(files.poses)
    ).load()
    expected = load_metric(weights).embed_scenes([scene])[0]
    assert content['embedding'] == pytest.approx(expected.tolist(), abs=1e-5)
    assert content['object_ids'] == ['tray', 'cup']


def _path(text):
    from pathlib import Path

    return Path(text)


def test_two_objects_of_one_model_get_different_ids(relations, scene_files, weights):
    files = scene_files['test']
    result = relations(
        'embed', '--base', files.base, '--relative', files.base, '--poses', files.poses,
        '--weights', weights, '--json', '-',
    )  # fmt: skip
    assert json.loads(result.stdout)['object_ids'] == ['carton_1', 'carton_2']
