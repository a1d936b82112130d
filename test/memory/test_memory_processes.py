"""The file under several processes, threads, and processes that die."""

import resource
import sqlite3
import subprocess
import sys
import threading

import numpy as np
import pytest

from spatial_relations_ros.core import MemoryFileError, Pose, Scene, SceneObject
from spatial_relations_ros.memory import RelationMemory, schema

WRITER = """
import os
import sys
import numpy as np
from spatial_relations_ros.core import Pose, Scene, SceneObject
from spatial_relations_ros.memory import RelationMemory

path, count, prefixes = sys.argv[1], int(sys.argv[2]), sys.argv[3]
points = np.arange(30000, dtype=np.float32).reshape(-1, 3)
scene = Scene(SceneObject('a', points, Pose()), SceneObject('b', points, Pose()))

def write(prefix):
    with RelationMemory(path) as memory:
        for idx in range(count):
            memory.remember(f'{prefix}{idx}', scene, np.full(8, idx), 'model')
            print(f'{prefix}{idx}', flush=True)

# The other prefixes in processes of their own.
for prefix in prefixes[1:]:
    if os.fork() == 0:
        write(prefix)
        os._exit(0)
write(prefixes[0])
for _ in prefixes[1:]:
    assert os.wait()[1] == 0
"""


def start_writer(path, count, prefixes, **kwargs):
    command = [sys.executable, '-c', WRITER, str(path), str(count), prefixes]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, **kwargs)


def test_killed_while_writing_keeps_every_finished_relation(tmp_path):
    path = tmp_path / 'relations.sqlite3'
    writer = start_writer(path, 100_000, 'w')
    finished = [writer.stdout.readline().strip() for _ in range(40)]
    writer.kill()
    finished += writer.stdout.read().split()
    writer.wait()
    with RelationMemory(path) as memory:
        names = {relation.name for relation in memory.list()}
        assert names >= set(finished)
        # At most the one whose success could not be reported any more.
        assert len(names) <= len(finished) + 1
        assert memory._connection.execute('PRAGMA integrity_check').fetchone() == ('ok',)
        for name in names:
            assert len(memory.get(name).base.points) == 10_000
        memory.remember('after', memory.get('w0'), np.ones(8), 'model')


def test_a_file_that_another_makes_meanwhile_is_taken_for_what_it_is(tmp_path):
    path = tmp_path / 'relations.sqlite3'
    connection = sqlite3.connect(path, timeout=10.0, isolation_level=None)
    others = []

    def make_it(statement):
        """Between two looks at the file, as another process may."""
        if statement == 'PRAGMA user_version' and not others:
            others.append(threading.Thread(target=lambda: schema.open_database(path).close()))
            others[0].start()
            others[0].join(0.5)  # it waits where the looks are at one state of the file

    connection.set_trace_callback(make_it)
    schema._prepare(connection, path)
    others[0].join()
    with RelationMemory(path) as memory:
        assert not memory.list()


def test_who_makes_the_file_waits_for_who_reads_it(tmp_path):
    path = tmp_path / 'relations.sqlite3'
    reader = sqlite3.connect(path, isolation_level=None, check_same_thread=False)
    reader.execute('BEGIN')
    reader.execute('SELECT 1 FROM sqlite_master').fetchone()
    release = threading.Timer(0.3, lambda: reader.execute('COMMIT'))
    release.start()
    with RelationMemory(path) as memory:
        assert not memory.list()
    release.join()


def test_several_processes_write_at_once(tmp_path):
    path = tmp_path / 'relations.sqlite3'
    writer = start_writer(path, 15, 'xyz')
    writer.stdout.read()
    assert writer.wait() == 0
    with RelationMemory(path) as memory:
        expected = {f'{prefix}{idx}' for prefix in 'xyz' for idx in range(15)}
        assert {relation.name for relation in memory.list()} == expected


def test_a_refusing_disk_is_reported(tmp_path):
    def limit():
        # Files may not grow beyond 1 MB: what a full quota does.
        resource.setrlimit(resource.RLIMIT_FSIZE, (1_000_000, 1_000_000))

    path = tmp_path / 'relations.sqlite3'
    writer = start_writer(path, 1000, 'w', preexec_fn=limit, stderr=subprocess.PIPE)
    finished, trouble = writer.communicate()
    assert writer.returncode != 0
    assert 'MemoryFileError' in trouble.splitlines()[-1]
    with RelationMemory(path) as memory:
        assert {relation.name for relation in memory.list()} == set(finished.split())


def test_threads_take_turns(tmp_path):
    points = np.zeros((10, 3), dtype=np.float32)
    scene = Scene(SceneObject('a', points, Pose()), SceneObject('b', points, Pose()))
    failures = []
    with RelationMemory(tmp_path / 'relations.sqlite3') as memory:

        def work(prefix):
            try:
                for idx in range(20):
                    memory.remember(f'{prefix}{idx}', scene, np.full(4, idx), 'model')
                    memory.nearest(np.zeros(4), 2, 'model')
            except Exception as error:
                failures.append(error)

        threads = [threading.Thread(target=work, args=(prefix,)) for prefix in 'abcd']
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert failures == []
        assert len(memory) == 80


def test_a_file_that_stays_locked_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(schema, 'BUSY_TIMEOUT_SEC', 0.05)
    path = tmp_path / 'relations.sqlite3'
    points = np.zeros((10, 3), dtype=np.float32)
    scene = Scene(SceneObject('a', points, Pose()), SceneObject('b', points, Pose()))
    with RelationMemory(path) as memory:
        blocker = sqlite3.connect(path, isolation_level=None)
        blocker.execute('BEGIN IMMEDIATE')
        with pytest.raises(MemoryFileError, match='locked'):
            memory.remember('one', scene, np.ones(4), 'model')
        blocker.execute('ROLLBACK')
        blocker.close()
        memory.remember('one', scene, np.ones(4), 'model')
