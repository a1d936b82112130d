"""The one file: copied, moved, replaced, of an earlier release, or not to be written."""

import os
import shutil
import sqlite3
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

from spatial_relations_ros.core import MemoryFileError, Pose, Scene, SceneObject
from spatial_relations_ros.memory import RelationMemory

POINTS = np.zeros((10, 3), dtype=np.float32)
SCENE = Scene(SceneObject('a', POINTS, Pose()), SceneObject('b', POINTS, Pose()))
MOVED = 'moved, removed or replaced'


def embed(scenes):
    return np.ones((len(scenes), 4))


@pytest.fixture
def memory(tmp_path):
    with RelationMemory(tmp_path / 'relations.sqlite3') as opened:
        opened.remember('one', SCENE, np.zeros(4), 'model')
        yield opened


def names(memory):
    return [relation.name for relation in memory.list()]


def copied(path):
    """Names and models in a copy of the one file."""
    copy = path.with_name('copy.sqlite3')
    shutil.copy(path, copy)
    with RelationMemory(copy) as memory:
        return {relation.name: relation.model_hash for relation in memory.list()}


def use_log(path):
    """A file as earlier releases made it; the connection keeps it so."""
    raw = sqlite3.connect(path, isolation_level=None)
    assert raw.execute('PRAGMA journal_mode = WAL').fetchone() == ('wal',)
    return raw


def test_a_copy_of_the_file_has_all_while_it_is_open(memory):
    assert copied(memory.path) == {'one': 'model'}
    memory.remember('two', SCENE, np.zeros(4), 'model')
    assert copied(memory.path) == {'one': 'model', 'two': 'model'}
    memory.forget('one')
    assert copied(memory.path) == {'two': 'model'}
    memory.nearest(np.zeros(4), 1, 'new', embed=embed)
    assert copied(memory.path) == {'two': 'new'}
    assert [path.name for path in memory.path.parent.iterdir() if 'copy' not in path.name] == [
        'relations.sqlite3'
    ]


KILLED = """
import os, signal, sys
import numpy as np
from spatial_relations_ros.memory import RelationMemory

memory = RelationMemory(sys.argv[1])
memory.remember('two', memory.get('one'), np.ones(4), 'model')
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_copy_has_all_that_a_killed_process_remembered(memory):
    memory.close()
    killed = subprocess.run([sys.executable, '-c', KILLED, str(memory.path)], check=False)
    assert killed.returncode == -9
    assert set(copied(memory.path)) == {'one', 'two'}


def test_a_log_that_an_earlier_release_left_goes_into_the_file(memory, tmp_path):
    raw = use_log(memory.path)
    memory.remember('two', SCENE, np.zeros(4), 'model')
    left = tmp_path / 'left'
    left.mkdir()
    for path in memory.path.parent.glob('relations.sqlite3*'):
        shutil.copy(path, left)
    raw.close()
    assert (left / 'relations.sqlite3-wal').stat().st_size > 0
    with RelationMemory(left / 'relations.sqlite3') as opened:
        assert names(opened) == ['one', 'two']
        assert set(copied(opened.path)) == {'one', 'two'}
        assert not (left / 'relations.sqlite3-wal').exists()


def test_a_log_that_others_use_goes_on(memory):
    raw = use_log(memory.path)
    raw.execute('BEGIN')
    raw.execute('SELECT 1 FROM relations').fetchall()
    with RelationMemory(memory.path) as opened:
        opened.remember('two', SCENE, np.zeros(4), 'model')
        assert names(opened) == ['one', 'two']
    raw.execute('COMMIT')
    assert raw.execute('SELECT COUNT(*) FROM relations').fetchone() == (2,)
    raw.close()


def remove(path):
    path.unlink()


def move(path):
    path.rename(path.with_name('away'))


def replace(path):
    shutil.copy(path, path.with_name('restored'))
    path.with_name('restored').replace(path)


@pytest.mark.parametrize('change', [remove, move, replace])
@pytest.mark.parametrize(
    'call',
    [
        lambda memory: memory.remember('two', SCENE, np.zeros(4), 'model'),
        lambda memory: memory.forget('one'),
        lambda memory: memory.get('one'),
        lambda memory: memory.list(),
        lambda memory: len(memory),
        lambda memory: memory.nearest(np.zeros(4), 1, 'model'),
    ],
)
def test_a_file_that_is_no_longer_there_is_not_used(memory, change, call):
    assert memory.is_in_place()
    change(memory.path)
    with pytest.raises(MemoryFileError, match=f'relations.sqlite3 was {MOVED}.* open it anew'):
        call(memory)
    assert not memory.is_in_place()
    with RelationMemory(memory.path) as new:
        new.remember('new', SCENE, np.zeros(4), 'model')
        memory.close()  # touches nothing of the new one
        assert names(new) == (['new', 'one'] if change is replace else ['new'])


def test_a_file_that_goes_while_others_embed_ends_the_search(memory):
    def embed_and_move(scenes):
        move(memory.path)
        return embed(scenes)

    with pytest.raises(MemoryFileError, match=MOVED):
        memory.nearest(np.zeros(4), 1, 'new', embed=embed_and_move)


def test_a_file_that_goes_after_a_look_at_it_is_not_written(memory):
    memory._identity.check = lambda: None  # it was there a moment ago
    move(memory.path)
    with pytest.raises(MemoryFileError, match=MOVED):
        memory.remember('two', SCENE, np.zeros(4), 'model')


def test_another_working_directory_moves_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with RelationMemory('relations.sqlite3') as memory:
        monkeypatch.chdir('/')
        assert memory.list() == ()


def test_a_file_that_is_locked_is_not_read_all_the_same(memory, monkeypatch):
    monkeypatch.setattr('spatial_relations_ros.memory.schema._is_read_only', lambda path: True)
    monkeypatch.setattr('spatial_relations_ros.memory.schema.BUSY_TIMEOUT_SEC', 0.1)
    with sqlite3.connect(memory.path) as writer:
        writer.execute('BEGIN EXCLUSIVE')
        with pytest.raises(MemoryFileError, match='kept the file locked'):
            RelationMemory(memory.path)
    writer.close()
    with RelationMemory(memory.path) as opened:
        assert names(opened) == ['one']


READER = """
import encodings.idna, os, sys
import numpy as np
from spatial_relations_ros.core import MemoryFileError
from spatial_relations_ros.memory import RelationMemory

if os.getuid() == 0:  # whom no permission stops
    os.setgid(65534)
    os.setuid(65534)
with RelationMemory(sys.argv[1]) as memory:
    scene = memory.get('one')
    print(scene.object_ids, [one.name for one in memory.list()], len(memory))
    print([one.name for one in memory.nearest(np.zeros(4), 1, 'model')])
    embed = lambda scenes: np.ones((len(scenes), 4))
    for call in (
        lambda: memory.remember('two', scene, np.zeros(4), 'model'),
        lambda: memory.forget('one'),
        lambda: memory.nearest(np.zeros(4), 1, 'new', embed=embed),
    ):
        try:
            call()
        except MemoryFileError as error:
            print(error)
    print(len(memory))
"""


@pytest.mark.parametrize('of_earlier_release', [False, True])
@pytest.mark.parametrize(('folder_mode', 'file_mode'), [(0o555, 0o644), (0o777, 0o444)])
def test_what_cannot_be_written_can_be_read(of_earlier_release, folder_mode, file_mode):
    # Not below tmp_path, where only its owner comes.
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'relations ?.sqlite3'
        with RelationMemory(path) as memory:
            memory.remember('one', SCENE, np.zeros(4), 'model')
        if of_earlier_release:
            use_log(path).close()
        path.chmod(file_mode)
        os.chmod(folder, folder_mode)
        try:
            command = [sys.executable, '-c', READER, str(path)]
            read = subprocess.run(command, text=True, capture_output=True, check=False)
        finally:
            os.chmod(folder, 0o755)
    assert read.returncode == 0, read.stderr
    lines = read.stdout.splitlines()
    assert lines[:2] == ["('a', 'b') ['one'] 1", "['one']"]
    assert (
        lines[2:5]
        == [f'{path}: is read-only: the file or its folder cannot be written; nothing was changed']
        * 3
    )
    assert lines[5] == '1'
