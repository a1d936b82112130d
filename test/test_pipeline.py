"""The demonstration bag through the step that live and replay share."""

from pathlib import Path

import numpy as np
import pytest

from spatial_relations_ros.core import CloudFormatError, CloudSource, UnknownObjectError
from spatial_relations_ros.evaluation.bag_reader import read_frames
from spatial_relations_ros.pipeline import LibraryModels, Pipeline

BAGS = Path(__file__).parents[1] / 'bags'
TABLE_HEIGHT = 0.72


@pytest.fixture(scope='module')
def models():
    return LibraryModels(BAGS / 'objects')


@pytest.fixture(scope='module')
def replayed(models):
    pipeline = Pipeline(models=models)
    return pipeline, [pipeline.step(frame) for frame in read_frames(BAGS / 'demo')]


def test_every_object_of_every_frame_is_known_and_confirmed(replayed, models):
    _, results = replayed
    assert len(results) == 20
    for result in results:
        assert result.problem is None
        assert result.rejected == {}
        assert tuple(result.objects) == models.object_ids
        assert min(item.support for item in result.objects.values()) > 0.8
        assert result.table_height == pytest.approx(TABLE_HEIGHT, abs=0.004)


def test_poses_jitter_about_places_that_are_physically_right(replayed):
    _, results = replayed
    lowest = {
        object_id: np.array(
            [result.objects[object_id].world_points[:, 2].min() for result in results]
        )
        for object_id in results[0].objects
    }
    for object_id in ('plate', 'pot', 'tray', 'basket', 'mug'):
        assert lowest[object_id].mean() == pytest.approx(TABLE_HEIGHT, abs=0.003)
        assert 0.0002 < lowest[object_id].std() < 0.004
    for object_id in ('cup', 'can'):
        assert 0.002 < lowest[object_id].mean() - TABLE_HEIGHT < 0.012


def test_scenes_are_those_of_the_last_frame(replayed):
    pipeline, results = replayed
    scene = pipeline.scene('plate', 'cup')
    assert scene.object_ids == ('plate', 'cup')
    assert scene.stamp_ns == results[-1].stamp_ns
    assert scene.relative.source == CloudSource.MODEL
    assert scene.relative.mesh is not None
    with pytest.raises(UnknownObjectError, match=r'teapot: .*known objects: basket, can, cup'):
        pipeline.scene('plate', 'teapot')


def test_a_second_replay_gives_the_same_numbers(replayed, models):
    _, results = replayed
    again = Pipeline(models=models)
    for frame, first in zip(read_frames(BAGS / 'demo'), results[:5], strict=False):
        second = again.step(frame)
        assert second.table_height == first.table_height
        for object_id, item in first.objects.items():
            np.testing.assert_array_equal(
                second.objects[object_id].world_points, item.world_points
            )
            assert second.objects[object_id].support == item.support


def test_without_models_the_objects_are_observed(replayed):
    pipeline = Pipeline()
    frame = next(read_frames(BAGS / 'demo'))
    result = pipeline.step(frame)
    known = replayed[1][0]
    for object_id in ('mug', 'tray', 'basket'):
        seen = result.objects[object_id]
        assert seen.source == CloudSource.OBSERVED
        low, high = (
            edge(known.objects[object_id].world_points, axis=0) for edge in (np.min, np.max)
        )
        inside = ((seen.world_points > low - 0.02) & (seen.world_points < high + 0.02)).all(axis=1)
        assert inside.mean() > 0.98


def test_before_the_first_cloud_and_after_a_reset_there_is_nothing(models):
    pipeline = Pipeline(models=models)
    with pytest.raises(UnknownObjectError, match='no cloud has arrived yet'):
        pipeline.scene('plate', 'cup')
    assert pipeline.result is None
    pipeline.step(next(read_frames(BAGS / 'demo')))
    pipeline.scene('plate', 'cup')
    pipeline.reset()
    with pytest.raises(UnknownObjectError, match='no cloud has arrived yet'):
        pipeline.scene('plate', 'cup')


def test_models_are_read_once_and_shared_by_alike_objects(models):
    cup = models.find('cup')
    assert cup is not None
    assert all(models.find(f'cup_{number}') is cup for number in range(20))
    assert models.find('teapot') is None


def test_a_damaged_model_keeps_saying_so(tmp_path):
    (tmp_path / 'cup.ply').write_bytes(b'ply\nnot a mesh\n')
    damaged = LibraryModels(tmp_path)
    for _ in range(2):
        with pytest.raises(CloudFormatError):
            damaged.find('cup')
    pipeline = Pipeline(models=damaged)
    result = pipeline.step(next(read_frames(BAGS / 'demo')))
    assert 'its model cannot be used' in result.rejected['cup']
    assert 'mug' in result.objects


def test_a_missing_folder_of_models_is_named(tmp_path):
    with pytest.raises(CloudFormatError, match='no_such_folder'):
        LibraryModels(tmp_path / 'no_such_folder')
