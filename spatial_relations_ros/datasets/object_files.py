"""Object models from files: meshes and clouds in metres."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from spatial_relations_ros.core import (
    CloudFormatError,
    TriangleMesh,
    UnknownObjectError,
    atomic_write,
)
from spatial_relations_ros.datasets.pcd_header import check_pcd_header
from spatial_relations_ros.datasets.ply_header import check_ply_header

MODEL_SUFFIXES = ('.ply', '.pcd', '.obj', '.stl', '.off')
PAPER_CLOUD_ENDING = '_uniform_leafzise_0.001'
MIN_POINTS = 4
SAMPLED_POINTS = 20_000

_LARGEST_EXTENT = 5.0
_SMALLEST_EXTENT = 0.002


def load_object_model(
    path: Path | str,
    *,
    num_points: int = SAMPLED_POINTS,
    check_units: bool = True,
    may_have_holes: bool = False,
) -> tuple[TriangleMesh | None, NDArray[np.float32]]:
    """Reads a model file (ply, pcd, obj, stl, off), in metres.

    Args:
        path: the file.
        num_points: how many points to spread over a mesh; a cloud's own points are kept.
        check_units: whether to warn of a size that no object in metres has.
        may_have_holes: whether points that are not finite, as cameras give them, are left out.

    Returns:
        The mesh, or None for a cloud; and points (N, 3) of its surface, object frame.

    Raises:
        CloudFormatError: for a missing, empty or unreadable file, an unknown format, points that
            are not finite, fewer than four points.
    """
    path = Path(path)
    _check_file(path)
    suffix = path.suffix.lower()
    if suffix == '.ply':
        check_ply_header(path)
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        mesh = None if suffix == '.pcd' else _read_mesh(path)
        points = (
            _read_cloud(path)
            if mesh is None
            else mesh.sample_surface(num_points, np.random.default_rng(0))
        )
    if may_have_holes:
        points = points[np.isfinite(points).all(axis=1)]
    if len(points) < MIN_POINTS:
        raise CloudFormatError(
            f'{path} holds {len(points)} points, at least {MIN_POINTS} are needed'
        )
    if not np.isfinite(points).all():
        bad = int((~np.isfinite(points).all(axis=1)).sum())
        raise CloudFormatError(f'{path}: {bad} of {len(points)} points are not finite')
    extent = float(np.ptp(points, axis=0).max())
    if extent == 0.0:
        raise CloudFormatError(f'{path}: all points are the same')
    if check_units:
        _check_units(path, extent)
    return mesh, points


def _check_file(path: Path) -> None:
    if path.suffix.lower() not in MODEL_SUFFIXES:
        raise CloudFormatError(
            f'{path}: format {path.suffix or "without suffix"} is not read; '
            f'{", ".join(suffix[1:] for suffix in MODEL_SUFFIXES)} are'
        )
    if not path.is_file():
        raise CloudFormatError(f'{path} does not exist; {_what_is_in(path.parent)}')
    if path.stat().st_size == 0:
        raise CloudFormatError(f'{path} is empty')


def _what_is_in(folder: Path) -> str:
    if not folder.is_dir():
        return f'there is no folder {folder}'
    names = sorted(p.name for p in folder.iterdir() if p.suffix.lower() in MODEL_SUFFIXES)
    if not names:
        return f'{folder} holds no model files'
    more = f' and {len(names) - 12} more' if len(names) > 12 else ''
    return f'{folder} holds {", ".join(names[:12])}{more}'


def _read_mesh(path: Path) -> TriangleMesh | None:
    mesh = o3d.io.read_triangle_mesh(path)
    vertices = np.asarray(mesh.vertices)
    triangles = np.asarray(mesh.triangles)
    if len(triangles) == 0:
        if path.suffix.lower() != '.ply':
            raise CloudFormatError(f'{path} holds no triangles that could be read')
        return None
    if not np.isfinite(vertices).all():
        raise CloudFormatError(f'{path} has vertices that are not finite')
    # Formats without shared vertices (stl) repeat them for each triangle.
    mesh.remove_duplicated_vertices()
    vertices = np.array(mesh.vertices, dtype=np.float32)
    triangles = np.array(mesh.triangles, dtype=np.int32)
    return TriangleMesh(vertices, triangles)


def _read_cloud(path: Path) -> NDArray[np.float32]:
    if path.suffix.lower() == '.pcd':
        check_pcd_header(path)
    cloud = o3d.io.read_point_cloud(path)
    points = np.array(cloud.points, dtype=np.float32).reshape(-1, 3)
    if len(points) == 0:
        raise CloudFormatError(f'{path} holds no points that could be read')
    return points


def _check_units(path: Path, extent: float) -> None:
    if extent > _LARGEST_EXTENT or extent < _SMALLEST_EXTENT:
        factor = 'divided by 1000 (millimetres?)' if extent > _LARGEST_EXTENT else 'scaled up'
        warnings.warn(
            f'{path}: largest extent {extent:.4g} m; models are in metres, should it be {factor}?',
            stacklevel=3,
        )


def save_mesh(path: Path | str, mesh: TriangleMesh) -> None:
    """Writes a mesh as binary ply, the same bytes for the same mesh."""
    header = (
        'ply\nformat binary_little_endian 1.0\n'
        f'element vertex {len(mesh.vertices)}\n'
        'property float x\nproperty float y\nproperty float z\n'
        f'element face {len(mesh.triangles)}\n'
        'property list uchar int vertex_indices\nend_header\n'
    )
    faces = np.empty(len(mesh.triangles), dtype=[('count', 'u1'), ('corners', '<i4', 3)])
    faces['count'] = 3
    faces['corners'] = mesh.triangles
    with atomic_write(path) as temporary:
        temporary.write_bytes(
            header.encode() + mesh.vertices.astype('<f4').tobytes() + faces.tobytes()
        )


def save_cloud(path: Path | str, points: NDArray[np.floating]) -> None:
    """Writes points (N, 3) as binary pcd."""
    header = (
        '# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\n'
        f'TYPE F F F\nCOUNT 1 1 1\nWIDTH {len(points)}\nHEIGHT 1\n'
        f'VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(points)}\nDATA binary\n'
    )
    with atomic_write(path) as temporary:
        temporary.write_bytes(header.encode() + np.ascontiguousarray(points, '<f4').tobytes())


class ObjectLibrary:
    """Object models of a folder by object id, read when first asked for.

    The model of ``cup`` is ``cup.<ext>`` or ``cup_uniform_leafzise_0.001.pcd``; ids of several
    alike objects (``cup_2``) fall back to the model without the number. Meshes come before
    clouds.
    """

    def __init__(self, folder: Path | str, *, num_points: int = SAMPLED_POINTS) -> None:
        """Looks at the folder's file names.

        Args:
            folder: with the model files, not searched below.
            num_points: how many points to spread over meshes.

        Raises:
            CloudFormatError: when there is no such folder.
        """
        self.folder = Path(folder)
        if not self.folder.is_dir():
            raise CloudFormatError(f'there is no folder of object models {self.folder}')
        self._num_points = num_points
        self._paths = model_paths(self.folder.iterdir())
        self._models: dict[str, tuple[TriangleMesh | None, NDArray[np.float32]]] = {}

    @property
    def object_ids(self) -> tuple[str, ...]:
        """Ids that have their own file, sorted."""
        return tuple(sorted(self._paths))

    def __contains__(self, object_id: str) -> bool:
        return self.resolve(object_id) is not None

    def __getitem__(self, object_id: str) -> tuple[TriangleMesh | None, NDArray[np.float32]]:
        """Mesh (None for clouds) and points (N, 3) of an object.

        Raises:
            UnknownObjectError: when the folder holds no model of it.
            CloudFormatError: when its file cannot be read.
        """
        name = self.resolve(object_id)
        if name is None:
            raise UnknownObjectError(f'no model of {object_id!r}; {_what_is_in(self.folder)}')
        if name not in self._models:
            self._models[name] = load_object_model(self._paths[name], num_points=self._num_points)
        return self._models[name]

    def resolve(self, object_id: str) -> str | None:
        """The id that an object's file has: its own, or that without a number at the end."""
        if object_id in self._paths:
            return object_id
        stem, _, number = object_id.rpartition('_')
        return stem if number.isdigit() and stem in self._paths else None


def model_paths(files: Iterable[Path]) -> dict[str, Path]:
    """Model files by object id; for several files of an id the mesh wins."""
    preference = {suffix: rank for rank, suffix in enumerate(('.ply', '.obj', '.stl', '.off'))}
    best: dict[str, Path] = {}
    for path in sorted(files):
        if path.suffix.lower() not in MODEL_SUFFIXES:
            continue
        name = path.stem.removesuffix(PAPER_CLOUD_ENDING)
        rank = preference.get(path.suffix.lower(), 9)
        if name not in best or rank < preference.get(best[name].suffix.lower(), 9):
            best[name] = path
    return best
