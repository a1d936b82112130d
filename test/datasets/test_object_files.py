"""Model files in every format, and what is wrong with bad ones."""

from __future__ import annotations

import numpy as np
import open3d as o3d
import pytest

from spatial_relations_ros.core import CloudFormatError, TriangleMesh, UnknownObjectError
from spatial_relations_ros.datasets.object_files import (
    ObjectLibrary,
    load_object_model,
    save_cloud,
    save_mesh,
)
from spatial_relations_ros.datasets.objects import sample_object


@pytest.fixture(scope='module')
def mesh() -> TriangleMesh:
    return sample_object('bowl', np.random.default_rng(0)).mesh


def write_with_open3d(path, mesh: TriangleMesh) -> None:
    written = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(mesh.vertices.astype(np.float64)),
        o3d.utility.Vector3iVector(np.array(mesh.triangles)),
    )
    written.compute_triangle_normals()
    assert o3d.io.write_triangle_mesh(path, written)


@pytest.mark.parametrize('suffix', ['ply', 'obj', 'stl', 'off'])
def test_meshes_of_every_format(suffix, mesh, tmp_path):
    write_with_open3d(tmp_path / f'bowl.{suffix}', mesh)
    read, points = load_object_model(tmp_path / f'bowl.{suffix}', num_points=500)
    assert read is not None
    assert len(read.triangles) == len(mesh.triangles)
    assert points.shape == (500, 3)
    np.testing.assert_allclose(
        np.abs(read.vertices).max(axis=0), np.abs(mesh.vertices).max(axis=0), atol=1e-5
    )
    edges = np.sort(read.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    counts = np.unique(edges, axis=0, return_counts=True)[1]
    assert (counts == 2).all(), 'the surface was closed before it was written'


def test_own_mesh_files_are_exact_and_repeatable(mesh, tmp_path):
    for name in ('a.ply', 'b.ply'):
        save_mesh(tmp_path / name, mesh)
    assert (tmp_path / 'a.ply').read_bytes() == (tmp_path / 'b.ply').read_bytes()
    read, _ = load_object_model(tmp_path / 'a.ply')
    assert read is not None
    np.testing.assert_array_equal(read.vertices, mesh.vertices)
    np.testing.assert_array_equal(read.triangles, mesh.triangles)


def test_clouds_as_binary_and_ascii(tmp_path):
    points = np.random.default_rng(0).random((50, 3)).astype(np.float32)
    save_cloud(tmp_path / 'binary.pcd', points)
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points.astype(np.float64)))
    o3d.io.write_point_cloud(tmp_path / 'ascii.pcd', cloud, write_ascii=True)
    o3d.io.write_point_cloud(tmp_path / 'cloud.ply', cloud)
    for name in ('binary.pcd', 'ascii.pcd', 'cloud.ply'):
        mesh, read = load_object_model(tmp_path / name)
        assert mesh is None
        np.testing.assert_allclose(read, points, atol=1e-6)


def test_a_missing_file_lists_what_is_there(mesh, tmp_path):
    save_mesh(tmp_path / 'bowl.ply', mesh)
    with pytest.raises(CloudFormatError, match=r'cup\.ply does not exist; .* holds bowl\.ply'):
        load_object_model(tmp_path / 'cup.ply')
    with pytest.raises(CloudFormatError, match='there is no folder'):
        load_object_model(tmp_path / 'absent' / 'cup.ply')


@pytest.mark.parametrize(
    ('name', 'content', 'complaint'),
    [
        ('a.ply', b'', 'is empty'),
        ('a.pcd', b'no cloud at all\n', 'no line FIELDS'),
        ('a.stl', b'no mesh at all\n', 'holds no triangles'),
        ('a.obj', b'v 0 0 0\n', 'holds no triangles'),
        ('a.step', b'x', r'format \.step is not read; ply, pcd'),
    ],
)
def test_unreadable_files(name, content, complaint, tmp_path):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(CloudFormatError, match=complaint):
        load_object_model(tmp_path / name)


def test_too_few_equal_or_not_finite_points(tmp_path):
    save_cloud(tmp_path / 'few.pcd', np.eye(3))
    with pytest.raises(CloudFormatError, match='3 points, at least 4'):
        load_object_model(tmp_path / 'few.pcd')
    save_cloud(tmp_path / 'same.pcd', np.ones((9, 3)))
    with pytest.raises(CloudFormatError, match='all points are the same'):
        load_object_model(tmp_path / 'same.pcd')


@pytest.mark.parametrize(('factor', 'hint'), [(1000.0, 'divided by 1000'), (1e-3, 'scaled up')])
def test_odd_units_are_warned_of(factor, hint, mesh, tmp_path):
    save_mesh(tmp_path / 'bowl.ply', TriangleMesh(mesh.vertices * factor, mesh.triangles))
    with pytest.warns(UserWarning, match=hint):
        load_object_model(tmp_path / 'bowl.ply')


def test_library_finds_models_by_id(mesh, tmp_path):
    save_mesh(tmp_path / 'cup.ply', mesh)
    points = np.random.default_rng(0).random((50, 3)).astype(np.float32)
    save_cloud(tmp_path / 'cup.pcd', points)
    save_cloud(tmp_path / 'tea_uniform_leafzise_0.001.pcd', points)
    (tmp_path / 'readme.txt').write_text('x')
    library = ObjectLibrary(tmp_path)
    assert library.object_ids == ('cup', 'tea')
    assert library['cup'][0] is not None, 'the mesh comes before the cloud'
    assert library['cup_2'][1] is library['cup'][1], 'read once'
    assert library['tea'][0] is None
    assert 'cup_12' in library
    assert 'cup_b' not in library
    with pytest.raises(UnknownObjectError, match=r"no model of 'pot'.*cup\.ply"):
        library['pot']
    with pytest.raises(CloudFormatError, match='no folder of object models'):
        ObjectLibrary(tmp_path / 'absent')


@pytest.mark.parametrize('is_ascii', [False, True])
@pytest.mark.parametrize('share', [0.99, 0.9, 0.5, 0.1, 0.01])
def test_plys_that_are_cut_off_are_refused(mesh, tmp_path, is_ascii, share):
    path = tmp_path / 'bowl.ply'
    written = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(mesh.vertices.astype(np.float64)),
        o3d.utility.Vector3iVector(np.array(mesh.triangles)),
    )
    assert o3d.io.write_triangle_mesh(path, written, write_ascii=is_ascii)
    read, _ = load_object_model(path)
    assert read is not None
    assert len(read.triangles) == len(mesh.triangles)
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(CloudFormatError, match='cut off'):
        load_object_model(path)


@pytest.mark.parametrize(
    ('header', 'message'),
    [
        ('ply\nelement vertex 1\nend_header\n', 'no format'),
        ('ply\nformat binary 1.0\nend_header\n', 'ply:2: .* is no line of a ply header'),
        ('ply\nformat ascii 1.0\nproperty float x\nend_header\n', 'ply:3'),
        ('ply\nformat ascii 1.0\nelement vertex many\nend_header\n', 'ply:3'),
        ('solid bowl\n', 'ply:1'),
    ],
)
def test_headers_of_plys_that_make_no_sense(tmp_path, header, message):
    (tmp_path / 'bowl.ply').write_text(header)
    with pytest.raises(CloudFormatError, match=message):
        load_object_model(tmp_path / 'bowl.ply')
