"""The library of own objects: units, axes, repair, storage."""

from __future__ import annotations

import json

import numpy as np
import pytest

from spatial_relations_ros.core import (
    CloudFormatError,
    ConfigError,
    ObjectExistsError,
    ObjectSizeError,
    TriangleMesh,
    UnknownObjectError,
)
from spatial_relations_ros.datasets.object_files import ObjectLibrary, save_cloud, save_mesh
from spatial_relations_ros.datasets.object_units import check_extent, unit_hint
from spatial_relations_ros.datasets.objects import sample_object
from spatial_relations_ros.datasets.own_objects import (
    UP_AXES,
    OwnObjects,
    default_objects_folder,
    prepare_object,
)
from spatial_relations_ros.datasets.solidify import is_watertight
from spatial_relations_ros.pipeline import LibraryModels


@pytest.fixture(scope='module')
def mug() -> TriangleMesh:
    return sample_object('mug', np.random.default_rng(1)).mesh


def scaled(mesh: TriangleMesh, factor: float) -> TriangleMesh:
    return TriangleMesh(factor * mesh.vertices, mesh.triangles)


@pytest.mark.parametrize(
    ('extent', 'hint'),
    [
        (95.0, 'probably millimetres; use --scale 0.001'),
        (240.0, 'probably millimetres; use --scale 0.001'),
        (12.0, 'centimetres (--scale 0.01: 0.12 m) or inches (--scale 0.0254: 0.305 m)?'),
        (1.5, '--size 0.15'),
        (0.0001, '--size 0.15'),
    ],
)
def test_what_unit_a_size_speaks_of(extent, hint):
    assert hint in unit_hint(extent)
    with pytest.raises(ObjectSizeError, match=f'mug is {extent:.4g} m large'):
        check_extent('mug', extent)


def test_what_is_scaled_on_purpose_may_be_large_but_not_absurd():
    check_extent('shelf', 2.0, on_purpose=True)
    with pytest.raises(ObjectSizeError, match='possible'):
        check_extent('shelf', 95.0, on_purpose=True)


def test_a_file_in_millimetres_is_refused_and_then_scaled(mug, tmp_path):
    save_mesh(tmp_path / 'mug.ply', scaled(mug, 1000.0))
    with pytest.raises(ObjectSizeError, match=r'mug\.ply is .* use --scale 0\.001'):
        prepare_object(tmp_path / 'mug.ply')
    prepared = prepare_object(tmp_path / 'mug.ply', scale=0.001)
    np.testing.assert_allclose(prepared.mesh.vertices, mug.vertices, atol=1e-6)
    assert prepared.card.made_from == 'mesh'
    sized = prepare_object(tmp_path / 'mug.ply', size=0.2)
    assert max(sized.card.size) == pytest.approx(0.2)


@pytest.mark.parametrize('up', UP_AXES)
def test_the_chosen_axis_becomes_up(up, tmp_path):
    axis = 'xyz'.index(up[-1])
    sign = -1.0 if up[0] == '-' else 1.0
    cone = np.zeros((4, 3), dtype=np.float32)
    others = [other for other in range(3) if other != axis]
    cone[0, others], cone[1, others], cone[2, others] = (0.1, 0.0), (-0.1, 0.1), (-0.1, -0.1)
    cone[3, axis] = 0.05 * sign
    triangles = np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])
    save_mesh(tmp_path / 'cone.ply', TriangleMesh(cone, triangles))
    card = prepare_object(tmp_path / 'cone.ply', up=up).card
    mesh = prepare_object(tmp_path / 'cone.ply', up=up).mesh
    assert mesh.vertices[:, 2].argmax() == np.argmax(sign * cone[:, axis])
    assert mesh.vertices[:, 2].max() == pytest.approx(0.05)
    assert mesh.vertices[:, 2].min() == pytest.approx(0.0)
    assert card.volume == pytest.approx(0.02 * 0.05 / 3.0, rel=1e-4)


def test_meshes_with_holes_and_clouds_become_watertight(mug, tmp_path):
    save_mesh(tmp_path / 'holed.ply', TriangleMesh(mug.vertices, mug.triangles[5:]))
    save_cloud(tmp_path / 'cloud.pcd', mug.sample_surface(40_000, np.random.default_rng(0)))
    holed = prepare_object(tmp_path / 'holed.ply')
    cloud = prepare_object(tmp_path / 'cloud.pcd')
    assert (holed.card.made_from, cloud.card.made_from) == ('repaired mesh', 'cloud')
    assert is_watertight(holed.mesh)
    assert is_watertight(cloud.mesh)
    assert cloud.card.volume == pytest.approx(holed.card.volume, rel=0.1)


@pytest.mark.parametrize(
    ('arguments', 'complaint'),
    [
        ({'name': 'my mug'}, '--name my_mug'),
        ({'name': '../mug'}, '--name mug'),
        ({'name': ''}, '--name object'),
        ({'scale': 0.0}, 'scale must be positive'),
        ({'size': float('nan')}, 'size must be positive'),
        ({'scale': 1.0, 'size': 1.0}, 'not both'),
        ({'up': 'w'}, "up axis 'w'"),
    ],
)
def test_what_cannot_be_prepared(mug, tmp_path, arguments, complaint):
    save_mesh(tmp_path / 'mug.ply', mug)
    with pytest.raises(ConfigError, match=complaint):
        prepare_object(tmp_path / 'mug.ply', **arguments)


def test_stored_objects_are_found_again_and_serve_perception(mug, tmp_path):
    save_mesh(tmp_path / 'mug.ply', mug)
    library = OwnObjects(tmp_path / 'library')
    assert library.names() == ()
    prepared = prepare_object(tmp_path / 'mug.ply', name='my_mug')
    path = library.add(prepared)
    assert library.names() == ('my_mug',)
    assert library.card('my_mug') == prepared.card
    with pytest.raises(ObjectExistsError, match='--replace'):
        library.add(prepared)
    assert library.add(prepared, replace=True) == path
    for source in (ObjectLibrary(library.folder), LibraryModels(library.folder)):
        assert source.object_ids == ('my_mug',)
    known = LibraryModels(library.folder).find('my_mug')
    assert known is not None
    assert known.mesh is not None
    np.testing.assert_array_equal(known.mesh.vertices, mug.vertices)


def test_unknown_and_damaged_cards(mug, tmp_path):
    save_mesh(tmp_path / 'mug.ply', mug)
    library = OwnObjects(tmp_path / 'library')
    with pytest.raises(UnknownObjectError, match='nothing yet; relations objects add'):
        library.card('mug')
    library.add(prepare_object(tmp_path / 'mug.ply'))
    with pytest.raises(UnknownObjectError, match=r"no object 'cup' .* there is 'mug'"):
        library.card('cup')
    for text in ('{', '[]', json.dumps({'name': 'mug'})):
        (library.folder / 'mug.json').write_text(text)
        with pytest.raises(CloudFormatError, match=r'damaged .* --replace'):
            library.card('mug')


def test_the_folder_lies_below_the_data_home(monkeypatch, tmp_path):
    monkeypatch.setenv('XDG_DATA_HOME', str(tmp_path))
    assert default_objects_folder() == tmp_path / 'spatial_relations_ros' / 'objects'
