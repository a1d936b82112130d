import dataclasses
import math
import sqlite3

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spatial_relations_ros.core import (
    CloudSource,
    ConfigError,
    InvalidSceneError,
    MemoryFileError,
    Pose,
    RelationExistsError,
    Scene,
    SceneObject,
    TriangleMesh,
    UnknownRelationError,
    WeightsError,
)
from spatial_relations_ros.memory import RelationMemory, default_memory_path


def make_scene(seed=0, *, mesh=True):
    rng = np.random.default_rng(seed)

    def item(object_id, **kwargs):
        quat = rng.normal(size=4)
        pose = Pose(rng.normal(size=3), quat / np.linalg.norm(quat))
        points = rng.normal(size=(rng.integers(4, 50), 3)).astype(np.float32)
        return SceneObject(object_id, points, pose, **kwargs)

    triangle = TriangleMesh(rng.normal(size=(3, 3)), np.array([[0, 1, 2]]))
    return Scene(
        item('bowl', mesh=triangle if mesh else None, support=0.75),
        item('cup_2', source=CloudSource.OBSERVED),
        stamp_ns=1_700_000_000_123_456_789,
        frame_id='map',
    )


@pytest.fixture
def memory(tmp_path):
    with RelationMemory(tmp_path / 'relations.sqlite3') as opened:
        yield opened


def assert_same_scene(first, second):
    assert (first.stamp_ns, first.frame_id) == (second.stamp_ns, second.frame_id)
    for one, other in zip(first.objects, second.objects, strict=True):
        assert (one.object_id, one.source) == (other.object_id, other.source)
        assert one.support == other.support or (
            math.isnan(one.support) and math.isnan(other.support)
        )
        assert np.array_equal(one.points, other.points)
        assert one.points.dtype == other.points.dtype
        poses = one.world_from_object, other.world_from_object
        assert np.array_equal(*(pose.translation for pose in poses))
        assert poses[0].quat_wxyz == pytest.approx(poses[1].quat_wxyz, abs=1e-15)
        assert (one.mesh is None) == (other.mesh is None)
        if one.mesh is not None:
            assert np.array_equal(one.mesh.vertices, other.mesh.vertices)
            assert np.array_equal(one.mesh.triangles, other.mesh.triangles)


@pytest.mark.parametrize('mesh', [True, False])
def test_a_scene_comes_back_as_it_was(memory, mesh):
    scene = make_scene(mesh=mesh)
    memory.remember('cup in bowl', scene, np.ones(64), 'a' * 64)
    assert_same_scene(memory.get('cup in bowl'), scene)


def test_another_process_start_finds_it(tmp_path):
    path = tmp_path / 'deep' / 'relations.sqlite3'
    with RelationMemory(path) as first:
        first.remember('one', make_scene(), np.ones(4), 'model')
    with RelationMemory(path) as second:
        (only,) = second.list()
        assert (only.name, only.base_id, only.relative_id) == ('one', 'bowl', 'cup_2')
        assert only.model_hash == 'model'
        assert second.nearest(np.ones(4), 1, 'model')[0].distance < 1e-6


def test_a_taken_name_is_refused_and_unchanged(memory):
    memory.remember('one', make_scene(1), np.ones(4), 'model')
    with pytest.raises(RelationExistsError, match="'one'"):
        memory.remember('one', make_scene(2), np.zeros(4), 'model')
    assert_same_scene(memory.get('one'), make_scene(1))
    memory.remember('one', make_scene(2), np.zeros(4), 'model', replace=True)
    assert_same_scene(memory.get('one'), make_scene(2))
    assert len(memory) == 1


def test_forget_removes_the_clouds_too(memory):
    memory.remember('one', make_scene(), np.ones(4), 'model')
    memory.forget('one')
    assert memory.list() == ()
    assert memory.nearest(np.ones(4), 3, 'model') == ()
    with sqlite3.connect(memory.path) as raw:
        assert raw.execute('SELECT COUNT(*) FROM objects').fetchone() == (0,)
    raw.close()


def test_unknown_names_say_what_there_is(memory):
    with pytest.raises(UnknownRelationError, match='none is so far'):
        memory.get('x')
    memory.remember('cup on plate', make_scene(), np.ones(4), 'model')
    for call in (memory.get, memory.forget):
        with pytest.raises(UnknownRelationError, match="there are 'cup on plate'"):
            call('x')


@pytest.mark.parametrize('name', ['', ' padded', 'x' * 201])
def test_names_that_are_none(memory, name):
    with pytest.raises(ConfigError, match='no name'):
        memory.remember(name, make_scene(), np.ones(4), 'model')


def test_a_name_that_is_no_utf8_is_refused_in_words(memory):
    with pytest.raises(ConfigError, match=r"'bad\\udcff' is no name .* UTF-8"):
        memory.remember('bad\udcff', make_scene(), np.ones(4), 'model')
    for call in (memory.get, memory.forget):
        with pytest.raises(UnknownRelationError, match=r"no relation 'bad\\udcff'"):
            call('bad\udcff')
    assert memory.list() == ()


@pytest.mark.parametrize('stamp_ns', [2**63, -(2**63) - 1])
def test_times_beyond_64_bits_are_refused(memory, stamp_ns):
    scene = dataclasses.replace(make_scene(), stamp_ns=stamp_ns)
    with pytest.raises(InvalidSceneError, match=f'time {stamp_ns} ns'):
        memory.remember('one', scene, np.ones(4), 'model')
    assert memory.list() == ()


@pytest.mark.parametrize('stamp_ns', [2**63 - 1, -(2**63)])
def test_the_last_times_of_64_bits_come_back(memory, stamp_ns):
    scene = dataclasses.replace(make_scene(), stamp_ns=stamp_ns)
    memory.remember('one', scene, np.ones(4), 'model')
    assert memory.get('one').stamp_ns == stamp_ns


def test_scenes_with_texts_that_are_no_utf8_are_refused(memory):
    scene = make_scene()
    base = dataclasses.replace(scene.base, object_id='\udcff')
    for bad in (
        dataclasses.replace(scene, base=base),
        dataclasses.replace(scene, frame_id='\udcff'),
    ):
        with pytest.raises(InvalidSceneError, match=r"'\\udcff' is no valid UTF-8"):
            memory.remember('one', bad, np.ones(4), 'model')
    assert memory.list() == ()


@pytest.mark.parametrize('embedding', [np.ones((2, 2)), np.array([]), np.array([1.0, np.nan])])
def test_embeddings_that_are_none(memory, embedding):
    with pytest.raises(ConfigError, match='embedding'):
        memory.remember('one', make_scene(), embedding, 'model')
    with pytest.raises(ConfigError, match='embedding'):
        memory.nearest(embedding, 1, 'model')


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), num=st.integers(1, 60), k=st.integers(1, 70))
def test_nearest_equals_sorting_all_distances(tmp_path_factory, seed, num, k):
    rng = np.random.default_rng(seed)
    # Far from the origin and close together: a product alone would lose these to cancellation.
    vectors = (50.0 + 1e-2 * rng.normal(size=(num, 8))).astype(np.float32)
    wanted = vectors[rng.integers(num)]
    scene = make_scene()
    with RelationMemory(tmp_path_factory.mktemp('memory') / 'm.sqlite3') as memory:
        for idx, vector in enumerate(vectors):
            memory.remember(f'{idx:03d}', scene, vector, 'model')
        found = memory.nearest(wanted, k, 'model')
    distances = np.linalg.norm(vectors.astype(float) - wanted, axis=1)
    order = np.argsort(distances, kind='stable')[:k]
    assert [neighbour.name for neighbour in found] == [f'{idx:03d}' for idx in order]
    assert [neighbour.distance for neighbour in found] == pytest.approx(distances[order], abs=1e-5)


def test_sees_what_it_and_others_write(memory):
    memory.remember('far', make_scene(), np.full(4, 9.0), 'model')
    assert memory.nearest(np.zeros(4), 1, 'model')[0].name == 'far'
    memory.remember('near', make_scene(), np.zeros(4), 'model')
    assert memory.nearest(np.zeros(4), 1, 'model')[0].name == 'near'
    with RelationMemory(memory.path) as other:
        other.forget('near')
        assert memory.nearest(np.zeros(4), 1, 'model')[0].name == 'far'
        other.remember('new', make_scene(), np.zeros(4), 'model')
    assert memory.nearest(np.zeros(4), 1, 'model')[0].name == 'new'


def test_reads_the_embeddings_once_while_nothing_changes(memory):
    memory.remember('one', make_scene(), np.ones(4), 'model')
    statements = []
    memory.nearest(np.zeros(4), 1, 'model')
    memory._connection.set_trace_callback(statements.append)
    memory.nearest(np.ones(4), 1, 'model')
    assert not any('SELECT' in statement for statement in statements)


def first_coordinate(scenes):
    return np.stack([np.full(4, scene.base.points[0, 0]) for scene in scenes])


def test_another_model_embeds_everything_anew_once(memory):
    scenes = [make_scene(seed) for seed in range(5)]
    for idx, scene in enumerate(scenes):
        memory.remember(str(idx), scene, np.zeros(4), 'old')
    with pytest.raises(WeightsError, match='5 of the relations'):
        memory.nearest(np.zeros(4), 1, 'new')
    calls = []

    def embed(batch):
        calls.append(len(batch))
        return first_coordinate(batch)

    wanted = first_coordinate([scenes[3]])[0]
    assert memory.nearest(wanted, 1, 'new', embed=embed)[0].name == '3'
    assert memory.nearest(wanted, 1, 'new', embed=embed)[0].distance < 1e-6
    assert sum(calls) == 5
    assert {relation.model_hash for relation in memory.list()} == {'new'}


def test_a_failing_embedding_changes_nothing(memory):
    memory.remember('one', make_scene(), np.zeros(4), 'old')

    def embed(batch):
        raise WeightsError('no weights')

    with pytest.raises(WeightsError, match='no weights'):
        memory.nearest(np.zeros(4), 1, 'new', embed=embed)
    assert memory.list()[0].model_hash == 'old'


def test_an_embedding_of_another_length_is_refused(memory):
    memory.remember('one', make_scene(), np.zeros(4), 'model')
    with pytest.raises(ConfigError, match='5 numbers'):
        memory.nearest(np.zeros(5), 1, 'model')
    with pytest.raises(ConfigError, match='at least one'):
        memory.nearest(np.zeros(4), 0, 'model')


def test_something_else_is_not_overwritten(tmp_path):
    text = tmp_path / 'notes.txt'
    text.write_text('these are notes, and not a database at all\n' * 100)
    with pytest.raises(MemoryFileError, match='not a file of remembered relations'):
        RelationMemory(text)
    assert text.read_text().startswith('these are notes')
    other = tmp_path / 'other.sqlite3'
    with sqlite3.connect(other) as raw:
        raw.execute('CREATE TABLE things (thing TEXT)')
    raw.close()
    with pytest.raises(MemoryFileError, match='something else'):
        RelationMemory(other)
    with pytest.raises(MemoryFileError):
        RelationMemory(tmp_path)


def test_a_newer_file_is_refused(memory):
    with sqlite3.connect(memory.path) as raw:
        raw.execute('PRAGMA user_version = 99')
    raw.close()
    with pytest.raises(MemoryFileError, match='newer release'):
        RelationMemory(memory.path)


def test_a_full_disk_changes_nothing(memory):
    memory.remember('one', make_scene(), np.ones(4), 'model')
    pages = memory._connection.execute('PRAGMA page_count').fetchone()[0]
    memory._connection.execute(f'PRAGMA max_page_count = {pages}')
    scene = make_scene()
    large = dataclasses.replace(
        scene.base, points=np.zeros((100_000, 3), dtype=np.float32), mesh=None
    )
    with pytest.raises(MemoryFileError, match='disk is full'):
        memory.remember('two', dataclasses.replace(scene, base=large), np.ones(4), 'model')
    assert [relation.name for relation in memory.list()] == ['one']
    assert_same_scene(memory.get('one'), make_scene())
    memory.forget('one')
    assert len(memory) == 0


def test_a_file_that_cannot_be_written(memory):
    memory._connection.execute('PRAGMA query_only = ON')
    with pytest.raises(MemoryFileError, match='cannot be written'):
        memory.remember('one', make_scene(), np.ones(4), 'model')


def test_default_path_follows_the_desktop_standard(monkeypatch, tmp_path):
    monkeypatch.setenv('XDG_DATA_HOME', str(tmp_path))
    expected = tmp_path / 'spatial_relations_ros' / 'relations.sqlite3'
    assert default_memory_path() == expected
    monkeypatch.setenv('XDG_DATA_HOME', 'relative/path')
    monkeypatch.setenv('HOME', '/home/somebody')
    assert str(default_memory_path()).startswith('/home/somebody/.local/share/')


@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    steps=st.lists(st.sampled_from(['own', 'other', 'replace', 'forget', 'foreign']), max_size=12),
)
def test_the_index_follows_whatever_writes(tmp_path_factory, seed, steps):
    """After each step a long-lived memory finds what one that has just been opened finds."""
    rng = np.random.default_rng(seed)
    scene = make_scene(mesh=False)

    def embed(batch):
        return np.full((len(batch), 4), 0.5, dtype=np.float32)

    path = tmp_path_factory.mktemp('memory') / 'm.sqlite3'
    with RelationMemory(path) as memory, RelationMemory(path) as other:
        for number, step in enumerate(steps):
            names = [relation.name for relation in memory.list()]
            writer = (memory, other)[int(rng.integers(2))]
            if step in ('forget', 'replace') and not names:
                continue
            if step == 'forget':
                writer.forget(names[rng.integers(len(names))])
            else:
                name = names[rng.integers(len(names))] if step == 'replace' else f'new {number}'
                writer = {'own': memory, 'other': other}.get(step, writer)
                model = 'foreign' if step == 'foreign' else 'model'
                writer.remember(name, scene, rng.normal(size=4), model, replace=True)
            wanted = rng.normal(size=4)
            found = memory.nearest(wanted, 20, 'model', embed=embed)
            with RelationMemory(path) as fresh:
                expected = fresh.nearest(wanted, 20, 'model')
            assert [one.name for one in found] == [one.name for one in expected]
            assert [one.distance for one in found] == pytest.approx(
                [one.distance for one in expected], abs=1e-5
            )


def test_a_write_of_others_is_followed_without_reading_all_again(memory):
    with RelationMemory(memory.path) as other:
        for idx in range(5):
            other.remember(str(idx), make_scene(mesh=False), np.full(4, idx), 'model')
        memory.nearest(np.zeros(4), 1, 'model')
        other.remember('new', make_scene(mesh=False), np.full(4, 9.0), 'model')
    rows = []
    memory._connection.row_factory = lambda _, row: rows.append(row) or row
    assert memory.nearest(np.full(4, 9.0), 1, 'model')[0].name == 'new'
    assert [row[1] for row in rows if len(row) == 3] == ['new']
