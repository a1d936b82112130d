import importlib.util
import json

import pytest

HAS_MUJOCO = importlib.util.find_spec('mujoco') is not None


def arguments(scene_files, weights, out):
    return [
        'imitate', *scene_files['reference'].options('reference'),
        *scene_files['test'].options('test'), '--weights', weights, '--steps', '1',
        '--physics', '--json', out,
    ]  # fmt: skip


@pytest.mark.skipif(not HAS_MUJOCO, reason='needs MuJoCo, the extra physics')
def test_answers_are_let_go_when_asked_for(relations, scene_files, weights, tmp_path):
    out = tmp_path / 'result.json'
    folder = tmp_path / 'shown'
    result = relations(*arguments(scene_files, weights, out), '--out', folder)
    assert result.exit_code in (0, 1), result.output
    assert (folder / 'result.json').read_bytes() == out.read_bytes()
    assert 'in simulation' in result.output
    for answer in json.loads(out.read_text())['answers']:
        simulation = answer['simulation']
        moved = [simulation[role] for role in ('base', 'relative')]
        far = any(m['shift'] > 0.02 or m['turn_rad'] > 0.262 for m in moved)
        assert simulation['stays'] == (not far)


@pytest.mark.skipif(HAS_MUJOCO, reason='MuJoCo is installed')
def test_without_mujoco_it_is_said_how_to_get_it(relations, scene_files, weights, tmp_path):
    result = relations(*arguments(scene_files, weights, tmp_path / 'result.json'))
    assert result.exit_code == 2
    assert 'pip install mujoco' in result.output
