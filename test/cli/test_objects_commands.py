import json
from pathlib import Path

import numpy as np
import pytest

from spatial_relations_ros.core import TriangleMesh
from spatial_relations_ros.datasets.object_files import load_object_model, save_mesh
from spatial_relations_ros.visualization import read_image


@pytest.fixture
def models(scene_files, tmp_path):
    """Files of three objects; the can is in millimetres."""
    for name in ('tray', 'cup', 'can'):
        mesh, _ = load_object_model(Path(scene_files['test'].base).with_name(f'{name}.ply'))
        factor = 1000.0 if name == 'can' else 1.0
        save_mesh(tmp_path / f'{name}.ply', TriangleMesh(factor * mesh.vertices, mesh.triangles))
    return tmp_path


def test_add_list_and_show(relations, models, tmp_path):
    added = relations('objects', 'add', models / 'cup.ply', '--name', 'my_cup', '--json', '-')
    assert added.exit_code == 0, added.output
    entry = json.loads(added.stdout)
    assert entry['path'] == str(
        tmp_path / 'share' / 'spatial_relations_ros' / 'objects' / 'my_cup.ply'
    )
    assert entry['size'] == pytest.approx([0.06, 0.06, 0.08])
    assert entry['volume'] == pytest.approx(0.06 * 0.06 * 0.08)
    picture = read_image(entry['preview'])
    assert picture.shape == (360, 480, 3)
    assert picture.std() > 5.0, 'something is to be seen'

    listed = json.loads(relations('objects', 'list', '--json', '-').stdout)
    assert [item['name'] for item in listed['objects']] == ['my_cup']
    assert relations('objects', 'list').stdout.startswith('1 object in ')
    assert json.loads(relations('objects', 'show', 'my_cup', '--json', '-').stdout) == entry
    assert 'watertight as it is' in relations('objects', 'show', 'my_cup').stdout


def test_units_are_questioned_before_anything_is_stored(relations, models, tmp_path):
    refused = relations('objects', 'add', models / 'can.ply', '--objects', tmp_path / 'own')
    assert refused.exit_code == 2
    assert 'can.ply is 70 m large: probably millimetres; use --scale 0.001' in refused.stderr
    assert not (tmp_path / 'own').exists()
    added = relations(
        'objects', 'add', models / 'can.ply', '--scale', '0.001', '--objects', tmp_path / 'own',
        '--no-preview',
    )  # fmt: skip
    assert added.exit_code == 0, added.output
    mesh, _ = load_object_model(tmp_path / 'own' / 'can.ply')
    assert np.ptp(mesh.vertices, axis=0).max() == pytest.approx(0.07)
    assert not (tmp_path / 'own' / 'previews').exists()


@pytest.mark.parametrize(
    ('arguments', 'complaint'),
    [
        (['add', 'none.ply'], 'none.ply does not exist'),
        (['add', 'CUP', '--name', 'a b'], '--name a_b'),
        (['add', 'CUP', '--scale', '1', '--size', '1'], 'not both'),
        (['add', 'CUP', '--up', 'w'], "'w'"),
        (['show', 'none'], "no object 'none'"),
    ],
)
def test_bad_input(relations, models, arguments, complaint):
    result = relations(
        'objects', *(models / 'cup.ply' if word == 'CUP' else word for word in arguments)
    )
    assert result.exit_code == 2, result.output
    assert complaint in result.stderr
    assert 'Traceback' not in result.stderr


def test_own_objects_are_placed_by_their_names(relations, models, scene_files, weights, tmp_path):
    own = tmp_path / 'own'
    for name in ('tray', 'cup'):
        relations('objects', 'add', models / f'{name}.ply', '--objects', own, '--no-preview')
    out = tmp_path / 'out.json'
    result = relations(
        'imitate', *scene_files['reference'].options('reference'), '--test-base', 'tray',
        '--test-relative', 'cup', '--objects', own, '--weights', weights, '--steps', 0,
        '--json', out,
    )  # fmt: skip
    assert result.exit_code in (0, 1), result.output
    poses = json.loads(out.read_text())['answers'][0]['poses']
    # Without poses they stand on z = 0; the base is not moved.
    assert poses['base']['t'] == pytest.approx([0.0, 0.0, 0.01], abs=1e-6)

    unknown = relations(
        'imitate', *scene_files['reference'].options('reference'), '--test-base', 'vase',
        '--test-relative', 'cup', '--objects', own,
    )  # fmt: skip
    assert unknown.exit_code == 2
    assert "no object 'vase'" in unknown.stderr
