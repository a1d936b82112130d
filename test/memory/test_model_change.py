"""Another model comes: what is remembered is embedded anew while others use the memory."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from spatial_relations_ros.core import MemoryFileError, Pose, Scene, SceneObject, WeightsError
from spatial_relations_ros.memory import RelationMemory
from spatial_relations_ros.memory.relation_memory import EMBED_BATCH

NUM_RELATIONS = EMBED_BATCH + 6
LIMIT_SEC = 20.0


def make_scene(number):
    """A scene that ``embed`` tells from others by its number."""
    points = np.full((4, 3), number, dtype=np.float32)
    return Scene(SceneObject('a', points, Pose()), SceneObject('b', points, Pose()))


def embed(scenes):
    return np.stack([np.full(4, scene.base.points[0, 0]) for scene in scenes])


def remember_all(memory):
    for idx in range(NUM_RELATIONS):
        memory.remember(f'{idx:03d}', make_scene(idx), np.zeros(4), 'old')


@pytest.fixture
def memory(tmp_path):
    with RelationMemory(tmp_path / 'relations.sqlite3') as opened:
        remember_all(opened)
        yield opened


@pytest.fixture
def elsewhere():
    """Runs a function on another thread, not for ever."""
    with ThreadPoolExecutor(max_workers=1) as pool:
        yield lambda call, *args, **kwargs: pool.submit(call, *args, **kwargs).result(LIMIT_SEC)


def names(neighbours):
    return [neighbour.name for neighbour in neighbours]


def test_nobody_waits_for_an_embedding(memory, elsewhere):
    listed = []

    def embed_slowly(scenes):
        listed.append(len(elsewhere(memory.list)))  # in vain if the lock is held
        return embed(scenes)

    found = memory.nearest(np.zeros(4), 1, 'new', embed=embed_slowly)
    assert names(found) == ['000']
    assert listed == [NUM_RELATIONS] * 2


@pytest.mark.parametrize('model', ['old', 'new'])
def test_what_is_replaced_or_forgotten_meanwhile_stays_so(memory, elsewhere, model):
    def embed_and_change(scenes):
        if len(scenes) == EMBED_BATCH:
            elsewhere(
                memory.remember, '002', make_scene(500), np.full(4, 500), model, replace=True
            )
            elsewhere(memory.forget, '003')
        return embed(scenes)

    memory.nearest(np.zeros(4), 1, 'new', embed=embed_and_change)
    found = memory.nearest(np.full(4, 500), NUM_RELATIONS, 'new', embed=embed)
    assert found[0].name == '002'
    assert found[0].distance == pytest.approx(0.0, abs=1e-3)
    expected = {f'{idx:03d}' for idx in range(NUM_RELATIONS)} - {'003'}
    assert set(names(found)) == expected
    assert memory.get('002').base.points[0, 0] == 500.0


def test_searches_with_either_model_meanwhile_leave_none_out(memory, elsewhere):
    def embed_while_others_search(scenes):
        if len(scenes) < EMBED_BATCH:
            for model in ('old', 'new'):
                with pytest.raises(WeightsError, match='of the relations'):
                    elsewhere(memory.nearest, np.zeros(4), 1, model)
        return embed(scenes)

    found = memory.nearest(np.zeros(4), 100, 'new', embed=embed_while_others_search)
    assert names(found) == [f'{idx:03d}' for idx in range(NUM_RELATIONS)]


def test_what_another_search_embedded_is_not_embedded_again(memory, elsewhere):
    batches = []

    def embed_after_another(scenes):
        if not batches:
            elsewhere(memory.nearest, np.zeros(4), 1, 'new', embed=embed)
        batches.append(len(scenes))
        return embed(scenes)

    found = memory.nearest(np.zeros(4), 100, 'new', embed=embed_after_another)
    assert names(found) == [f'{idx:03d}' for idx in range(NUM_RELATIONS)]
    assert batches == [EMBED_BATCH]


def test_all_forgotten_meanwhile_is_nothing_to_embed(memory, elsewhere):
    def embed_and_forget(scenes):
        if len(scenes) == EMBED_BATCH:
            for idx in range(EMBED_BATCH, NUM_RELATIONS):
                elsewhere(memory.forget, f'{idx:03d}')
        return embed(scenes)

    found = memory.nearest(np.zeros(4), 100, 'new', embed=embed_and_forget)
    assert len(found) == EMBED_BATCH


def test_an_end_between_batches_keeps_what_was_done(memory):
    def embed_once(scenes):
        if len(scenes) < EMBED_BATCH:
            raise WeightsError('the end')
        return embed(scenes)

    with pytest.raises(WeightsError, match='the end'):
        memory.nearest(np.zeros(4), 1, 'new', embed=embed_once)
    models = [relation.model_hash for relation in memory.list()]
    assert models == ['new'] * EMBED_BATCH + ['old'] * 6
    found = memory.nearest(np.zeros(4), 100, 'new', embed=embed)
    assert names(found) == [f'{idx:03d}' for idx in range(NUM_RELATIONS)]


@pytest.mark.parametrize(
    'damage',
    [
        "UPDATE objects SET points = x'00000000'",
        "UPDATE objects SET points = x'0000'",
        'UPDATE objects SET points = zeroblob(12)',
        "UPDATE objects SET points = 'text'",
        "UPDATE objects SET pose = x''",
        'UPDATE objects SET source = 9',
        "UPDATE objects SET support = 'none'",
        "UPDATE objects SET object_id = CAST(x'ff' AS TEXT)",
        'UPDATE objects SET vertices = zeroblob(36), triangles = NULL',
        "UPDATE objects SET vertices = zeroblob(36), triangles = x'00000000'",
        'DELETE FROM objects',
    ],
)
def test_a_damaged_relation_is_named_and_left_out(memory, damage):
    memory._connection.execute(
        f'{damage} WHERE role = 1 AND relation_id = '
        "(SELECT relation_id FROM relations WHERE name = '001')"
    )
    with pytest.raises(MemoryFileError, match=r"'001' is damaged .*; replace or forget it"):
        memory.get('001')
    with pytest.warns(UserWarning, match=r"'001' is damaged") as warned:
        found = memory.nearest(np.zeros(4), 100, 'new', embed=embed)
    assert len(warned) == 1
    expected = [f'{idx:03d}' for idx in range(NUM_RELATIONS)]
    expected.remove('001')
    assert names(found) == expected
    memory.remember('001', make_scene(1), np.ones(4), 'new', replace=True)
    assert memory.nearest(np.ones(4), 1, 'new')[0].name == '001'


def test_a_damaged_relation_costs_later_searches_nothing(memory):
    warned = []
    with RelationMemory(memory.path, warn=warned.append) as other:
        other._connection.execute('UPDATE objects SET source = 9 WHERE relation_id = 1')
        other.nearest(np.zeros(4), 1, 'new', embed=embed)
        statements = []
        other._connection.set_trace_callback(statements.append)
        assert other.nearest(np.zeros(4), 1, 'new')[0].name == '001'
    assert not any('SELECT' in statement for statement in statements)
    assert len(warned) == 1


RENEWER = """
import sys
import numpy as np
from spatial_relations_ros.memory import RelationMemory

def embed(scenes):
    print(len(scenes), flush=True)
    if len(scenes) < 64:
        sys.stdin.read()  # until it is killed
    return np.ones((len(scenes), 4))

with RelationMemory(sys.argv[1]) as memory:
    memory.nearest(np.zeros(4), 1, 'new', embed=embed)
"""


def test_killed_while_embedding_keeps_finished_batches(memory):
    renewer = subprocess.Popen(
        [sys.executable, '-c', RENEWER, str(memory.path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    with renewer:
        assert [renewer.stdout.readline().strip() for _ in range(2)] == [str(EMBED_BATCH), '6']
        memory.forget('069')  # another process does not wait either
        renewer.kill()
    models = [relation.model_hash for relation in memory.list()]
    assert models == ['new'] * EMBED_BATCH + ['old'] * 5
    assert memory._connection.execute('PRAGMA integrity_check').fetchone() == ('ok',)
    found = memory.nearest(np.zeros(4), 100, 'new', embed=embed)
    assert len(found) == NUM_RELATIONS - 1
