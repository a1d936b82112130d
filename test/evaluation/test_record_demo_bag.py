"""The recorder of the demonstration, and the scene that it records."""

import itertools
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from spatial_relations_ros.core import ConfigError, Relation
from spatial_relations_ros.datasets.object_files import ObjectLibrary
from spatial_relations_ros.evaluation.demo_scenario import (
    IMITATIONS,
    TABLE_HEIGHT,
    TABLE_SIZE,
    make_scenario,
    world_from_camera,
)
from spatial_relations_ros.evaluation.moving_scenario import MOVED_ID, objects_at
from spatial_relations_ros.evaluation.record_demo_bag import (
    IR_FRAME,
    RGB_FRAME,
    RecordingOptions,
    main,
    record_demo_bag,
    static_transforms,
)
from spatial_relations_ros.perception.frames import TransformBuffer


@pytest.fixture(scope='module')
def objects():
    return {item.object_id: item for item in make_scenario(RecordingOptions.seed)}


def lowest(item):
    return item.world_from_object.apply(item.model.mesh.vertices)[:, 2].min()


def test_the_same_seed_gives_the_same_bytes_in_place_of_an_older_recording(tmp_path, objects):
    new, old = tmp_path / 'new', tmp_path / 'old'
    (old / 'demo').mkdir(parents=True)
    for name in ('README.md', 'demo/metadata.yaml', 'demo/old.mcap'):
        (old / name).touch()
    main([str(new), '--duration', '0.2', '--cloud-rate', '5'])
    record_demo_bag(old, RecordingOptions(duration_sec=0.2, cloud_rate=5.0))
    contents = [
        {path.relative_to(folder): path.read_bytes() for path in folder.rglob('*.*')}
        for folder in (new, old)
    ]
    assert contents[1].pop(Path('README.md')) == b''
    assert contents[0] == contents[1]
    assert len(contents[0]) == 10  # bag, metadata, description and seven meshes
    library = ObjectLibrary(new / 'objects')
    assert set(library.object_ids) == set(objects)
    mesh, _ = library['mug']
    np.testing.assert_array_equal(mesh.vertices, objects['mug'].model.mesh.vertices)


def test_each_demonstrated_pair_is_in_contact_and_the_others_stand_on_the_table(objects):
    supported = {item.reference_ids[1] for item in IMITATIONS}
    for object_id, item in objects.items():
        if object_id in supported:
            assert lowest(item) > TABLE_HEIGHT + 0.003
        else:
            assert lowest(item) == pytest.approx(TABLE_HEIGHT, abs=1e-5)
        reach = np.abs(item.world_from_object.apply(item.model.mesh.vertices)[:, :2])
        assert (reach < np.array(TABLE_SIZE) / 2).all()
    for imitation in IMITATIONS:
        base, relative = (objects[object_id] for object_id in imitation.reference_ids)
        opening = base.model.opening
        floor = base.world_from_object.translation[2] + opening.floor_z
        assert lowest(relative) == pytest.approx(floor, abs=0.002)
        is_deep = opening.depth > 0.05
        assert is_deep == (imitation.relation is Relation.INSIDE)


def test_objects_that_stand_apart_are_apart(objects):
    pairs = {frozenset(item.reference_ids) for item in IMITATIONS}
    rng = np.random.default_rng(0)
    points = {
        object_id: item.world_from_object.apply(item.model.mesh.sample_surface(8000, rng))
        for object_id, item in objects.items()
    }
    for first, second in itertools.combinations(points, 2):
        gap = cKDTree(points[first]).query(points[second])[0].min()
        if frozenset((first, second)) in pairs:
            assert gap < 0.003
        else:
            assert gap > 0.02


def test_the_transforms_place_both_cameras_in_one_housing():
    buffer = TransformBuffer()
    for transform in static_transforms(0):
        buffer.add(transform)
    assert buffer.lookup('world', IR_FRAME, 0).is_close(world_from_camera())
    offset = buffer.lookup(IR_FRAME, RGB_FRAME, 0)
    np.testing.assert_allclose(offset.translation, [-0.052, 0, 0], atol=1e-12)
    # The housing's frame is that of a body: x forward, where the optical frame's z points.
    link_from_ir = buffer.lookup('kinect2_link', IR_FRAME, 0)
    np.testing.assert_allclose(link_from_ir.rotation @ [0, 0, 1], [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(link_from_ir.rotation @ [0, -1, 0], [0, 0, 1], atol=1e-12)


def test_refuses_rates_that_record_nothing():
    with pytest.raises(ConfigError, match='must be positive'):
        RecordingOptions(cloud_rate=0)


def test_a_moving_demonstration_leaves_the_plate_and_ends_on_the_table(objects):
    items = tuple(objects.values())
    first, held, last = (
        {item.object_id: item for item in objects_at(items, share)} for share in (0.2, 0.5, 0.9)
    )
    assert lowest(first[MOVED_ID]) == pytest.approx(lowest(objects[MOVED_ID]))
    assert lowest(held[MOVED_ID]) > lowest(objects[MOVED_ID]) + 0.05
    assert lowest(last[MOVED_ID]) == pytest.approx(TABLE_HEIGHT, abs=1e-5)
    for object_id, item in objects.items():
        if object_id == MOVED_ID:
            continue
        assert last[object_id].world_from_object is item.world_from_object
        points = item.world_from_object.apply(item.model.mesh.vertices)
        moved = last[MOVED_ID].world_from_object.apply(last[MOVED_ID].model.mesh.vertices)
        assert cKDTree(points).query(moved)[0].min() > 0.01, f'put down on the {object_id}'


def test_a_bag_of_it_is_recorded_beside_the_objects(tmp_path):
    main([str(tmp_path), '--duration', '0.4', '--cloud-rate', '5', '--moving'])
    assert (tmp_path / 'moving' / 'metadata.yaml').is_file()
    assert not (tmp_path / 'demo').exists()
