import json
import sqlite3


def test_remember_find_imitate_and_forget(relations, data, weights, tmp_path):
    def scene(name):
        return ['--data', data, '--scene', name, '--weights', weights]

    for name in ('tray_cup_0', 'carton_can_0'):
        result = relations('remember', f'my {name}', *scene(name))
        assert result.exit_code == 0, result.output
    assert (tmp_path / 'share' / 'spatial_relations_ros' / 'relations.sqlite3').is_file()

    listed = json.loads(relations('list', '--json', '-').stdout)['relations']
    assert [item['name'] for item in listed] == ['my carton_can_0', 'my tray_cup_0']
    assert listed[1]['base_id'] == 'tray'
    assert listed[1]['stamp_ns'] > 1_000_000_000_000_000_000

    found = json.loads(relations('nearest', *scene('tray_cup_1'), '--json', '-').stdout)
    assert len(found['neighbours']) == 2
    nearest, other = found['neighbours']
    assert nearest['distance'] <= other['distance']
    same = json.loads(relations('nearest', *scene('tray_cup_0'), '-k', '1', '--json', '-').stdout)
    assert same['neighbours'][0]['name'] == 'my tray_cup_0'
    assert same['neighbours'][0]['distance'] < 1e-3

    taken = relations('remember', 'my tray_cup_0', *scene('tray_cup_1'))
    assert taken.exit_code == 2
    assert 'remembered already' in taken.stderr
    assert relations('remember', 'my tray_cup_0', *scene('tray_cup_1'), '--replace').exit_code == 0

    assert relations('forget', 'my tray_cup_0').exit_code == 0
    again = relations('forget', 'my tray_cup_0')
    assert again.exit_code == 2
    assert "there are 'my carton_can_0'" in again.stderr


def test_a_remembered_relation_can_be_imitated(relations, data, weights, tmp_path):
    memory = tmp_path / 'memory.sqlite3'
    out = tmp_path / 'out.json'
    relations(
        'remember', 'on tray', '--data', data, '--scene', 'tray_cup_0',
        '--weights', weights, '--memory', memory,
    )  # fmt: skip
    result = relations(
        'imitate', '--remembered', 'on tray', '--memory', memory, '--data', data,
        '--test', 'carton_can_0', '--weights', weights, '--steps', 0, '--json', out,
    )  # fmt: skip
    assert result.exit_code in (0, 1), result.output
    assert json.loads(out.read_text())['answers']


def test_another_files_error(relations, tmp_path):
    notes = tmp_path / 'notes.txt'
    notes.write_text('not a database, but long enough to look at ' * 10)
    result = relations('list', '--memory', notes)
    assert result.exit_code == 1
    assert 'not a file of remembered relations' in result.stderr


def test_other_weights_embed_what_is_remembered_anew(relations, data, weights, calibrated_weights):
    scene = ['--data', data, '--scene', 'tray_cup_0']
    relations('remember', 'shown', *scene, '--weights', weights)
    before = json.loads(relations('list', '--json', '-').stdout)['relations'][0]['model_hash']
    found = relations('nearest', *scene, '--weights', calibrated_weights, '--json', '-')
    assert json.loads(found.stdout)['neighbours'][0]['distance'] < 1e-3
    after = json.loads(relations('list', '--json', '-').stdout)['relations'][0]['model_hash']
    assert after == json.loads(found.stdout)['model_hash'] != before


def test_a_name_that_is_no_utf8_is_refused_in_words(relations, data, weights):
    name = b'bad\xff'.decode(errors='surrogateescape')  # as Python takes such an argument
    scene = ['--data', data, '--scene', 'tray_cup_0', '--weights', weights]
    remembered = relations('remember', name, *scene)
    assert remembered.exit_code == 2, remembered.output
    assert 'no valid UTF-8' in remembered.stderr
    forgotten = relations('forget', name)
    assert forgotten.exit_code == 2, forgotten.output
    assert 'no relation' in forgotten.stderr


def test_a_damaged_relation_is_a_warning(relations, data, weights, calibrated_weights, tmp_path):
    scene = ['--data', data, '--scene', 'tray_cup_0', '--memory', tmp_path / 'relations.sqlite3']
    for name in ('good', 'bad'):
        relations('remember', name, *scene, '--weights', weights)
    with sqlite3.connect(tmp_path / 'relations.sqlite3') as raw:
        raw.execute("UPDATE objects SET points = x'00000000' WHERE relation_id = 2")
    raw.close()
    found = relations('nearest', *scene, '--weights', calibrated_weights, '--json', '-')
    assert found.exit_code == 0, found.output
    assert [item['name'] for item in json.loads(found.stdout)['neighbours']] == ['good']
    assert "warning: the remembered relation 'bad' is damaged" in found.stderr


def test_names_with_brackets_are_shown_as_they_are(relations, data, weights):
    name = 'a [/b] [on] c'
    scene = ['--data', data, '--scene', 'tray_cup_0', '--weights', weights]
    for command in (['remember', name, *scene], ['list'], ['nearest', *scene]):
        result = relations(*command)
        assert result.exit_code == 0, result.output
        assert name in result.stdout
    listed = json.loads(relations('list', '--json', '-').stdout)['relations']
    assert [item['name'] for item in listed] == [name]
    forgotten = relations('forget', name)
    assert name in forgotten.stdout


def test_a_mistyped_file_is_not_made_by_looking_into_it(relations, data, weights, tmp_path):
    typo = tmp_path / 'typo.sqlite3'
    scene = ['--data', data, '--scene', 'tray_cup_0', '--weights', weights]
    remembered = ['imitate', '--remembered', 'x', '--data', data, '--test', 'carton_can_0']
    for command in (['list'], ['nearest', *scene], ['forget', 'x'], remembered):
        result = relations(*command, '--memory', typo)
        assert result.exit_code == 2, result.output
        assert 'there is no file' in result.stderr
    assert not typo.exists()
