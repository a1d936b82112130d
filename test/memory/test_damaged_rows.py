"""One damaged row: it is named and left out, and everything else works."""

import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError, Pose, Scene, SceneObject, UnknownRelationError
from spatial_relations_ros.memory import RelationMemory

NAMES = ['one', 'two', 'three', 'four']
DIM = 4


def make_scene():
    points = np.zeros((10, 3), dtype=np.float32)
    return Scene(SceneObject('a', points, Pose()), SceneObject('b', points, Pose()))


def blob(*numbers):
    return np.array(numbers, dtype='<f4').tobytes()


@pytest.fixture
def warned():
    return []


@pytest.fixture
def memory(tmp_path, warned):
    with RelationMemory(tmp_path / 'relations.sqlite3', warn=warned.append) as opened:
        for idx, name in enumerate(NAMES):
            opened.remember(name, make_scene(), np.full(DIM, idx), 'model')
        yield opened


def damage(memory, column, value, name='two'):
    """In another connection, as an accident would."""
    with RelationMemory(memory.path) as other:
        other._connection.execute(
            f'UPDATE relations SET {column} = ? WHERE name = ?', (value, name)
        )


def damage_name(memory):
    with RelationMemory(memory.path) as other:
        other._connection.execute(
            "UPDATE relations SET name = CAST(x'ff61' AS TEXT) WHERE name = 'two'"
        )


def found(memory, idx=0):
    return {one.name: one.distance for one in memory.nearest(np.full(DIM, idx), 10, 'model')}


EXPECTED = {'one': 0.0, 'three': 4.0, 'four': 6.0}


@pytest.mark.parametrize(
    ('value', 'reason'),
    [
        (b'\0', 'its embedding has 1 bytes where others have 16'),
        (b'', 'its embedding has 0 bytes where others have 16'),
        (blob(1, 2), 'its embedding has 8 bytes where others have 16'),
        (blob(1, 2, 3, 4, 5), 'its embedding has 20 bytes where others have 16'),
        (blob(1, np.nan, 1, 1), 'its embedding has numbers that are not finite'),
        (blob(1, np.inf, 1, 1), 'its embedding has numbers that are not finite'),
        ('text of sixteen.', 'its embedding is no blob of numbers'),
        (7, 'its embedding is no blob of numbers'),
    ],
    ids=['one byte', 'empty', 'cut', 'too long', 'NaN', 'infinite', 'text', 'number'],
)
@pytest.mark.parametrize('is_read_before', [False, True])
def test_a_damaged_embedding_is_left_out(memory, warned, value, reason, is_read_before):
    if is_read_before:
        memory.nearest(np.zeros(DIM), 1, 'model')
        memory.remember('two', make_scene(), np.zeros(DIM), 'model', replace=True)
    damage(memory, 'embedding', value)
    for _ in range(2):
        assert found(memory) == pytest.approx(EXPECTED, abs=1e-6)
    assert warned == [
        f"the remembered relation 'two' is damaged ({reason}); replace or forget it. "
        'It is left out until then'
    ]
    assert len(memory.list()) == len(memory) == len(NAMES)
    memory.remember('two', make_scene(), np.full(DIM, 1), 'model', replace=True)
    assert found(memory) == pytest.approx({**EXPECTED, 'two': 2.0}, abs=1e-6)
    assert len(warned) == 1


def test_what_another_model_embeds_anew_is_whole_again(memory, warned):
    damage(memory, 'embedding', b'\0')
    embedded = memory.nearest(
        np.zeros(DIM), 10, 'new', embed=lambda scenes: np.zeros((len(scenes), DIM))
    )
    assert {one.name for one in embedded} == set(NAMES)
    assert warned == []


def test_the_first_row_may_be_the_damaged_one(memory, warned):
    damage(memory, 'embedding', blob(1, 2), name='one')
    for name in NAMES[2:]:
        memory.forget(name)
    # One of each length: that of the embedding in question counts.
    assert list(found(memory)) == ['two']
    assert "'one'" in warned[0]


def test_a_damaged_row_alone_does_not_set_the_length(memory):
    for name in NAMES[1:]:
        memory.forget(name)
    damage(memory, 'embedding', blob(1, 2), name='one')
    with pytest.raises(ConfigError, match='4 numbers, the remembered ones have 2'):
        found(memory)
    memory.remember('new', make_scene(), np.zeros(DIM), 'model')
    assert list(found(memory)) == ['new']


def test_damaged_rows_that_are_forgotten_are_not_looked_for(memory):
    damage(memory, 'embedding', b'\0')
    found(memory)
    with RelationMemory(memory.path) as other:
        other.forget('two')
        other.forget('three')
    assert list(found(memory)) == ['one', 'four']
    statements = []
    memory.remember('new', make_scene(), np.zeros(DIM), 'model')
    memory._connection.set_trace_callback(statements.append)
    assert list(found(memory)) == ['new', 'one', 'four']
    assert not any('group_concat' in statement for statement in statements)


def test_a_damaged_name_is_left_out_and_can_be_forgotten(memory, warned):
    damage_name(memory)
    for _ in range(2):
        assert {relation.name for relation in memory.list()} == {'one', 'three', 'four'}
        assert found(memory) == pytest.approx(EXPECTED, abs=1e-6)
    assert warned == [
        "the remembered relation of id 2 is damaged (its name b'\\xffa' is no valid UTF-8); "
        'forget it by that name. It is left out until then'
    ]
    with pytest.raises(UnknownRelationError, match=r"there are .*'four'"):
        memory.get('x')
    memory.forget(b'\xffa'.decode(errors='surrogateescape'))
    assert len(memory) == 3


@pytest.mark.parametrize(
    ('column', 'value', 'reason'),
    [
        ('frame_id', "CAST(x'ff' AS TEXT)", 'one of its texts is no valid UTF-8'),
        ('frame_id', "x'ff'", 'one of its texts is no valid UTF-8'),
        ('stamp_ns', "'never'", "its time 'never' is no whole number"),
    ],
)
def test_a_relation_that_cannot_be_listed_is_left_out(memory, warned, column, value, reason):
    memory._connection.execute(f"UPDATE relations SET {column} = {value} WHERE name = 'two'")
    for _ in range(2):
        assert {relation.name for relation in memory.list()} == {'one', 'three', 'four'}
    assert len(warned) == 1
    assert f"'two' is damaged ({reason})" in warned[0]


def test_a_relation_without_its_objects_is_left_out_of_the_list(memory, warned):
    memory._connection.execute('DELETE FROM objects WHERE relation_id = 2 AND role = 1')
    assert {relation.name for relation in memory.list()} == {'one', 'three', 'four'}
    assert "'two' is damaged (it has less than two objects)" in warned[0]
