"""A person's own objects: meshes made fit for use, in one folder."""

from __future__ import annotations

import json
import re
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import (
    CloudFormatError,
    ConfigError,
    ObjectExistsError,
    TriangleMesh,
    UnknownObjectError,
    atomic_write,
    data_path,
)
from spatial_relations_ros.datasets.object_files import load_object_model, save_mesh
from spatial_relations_ros.datasets.object_units import check_extent
from spatial_relations_ros.datasets.solidify import solid_from_cloud, watertight

UP_AXES = ('z', '-z', 'y', '-y', 'x', '-x')
PREVIEWS = 'previews'

_NAME = re.compile(r'[A-Za-z0-9][A-Za-z0-9_-]{0,63}')
_CARD = '.json'
# Rows are where the axes of the stored frame lie in the file's; each is a proper rotation.
_ROTATIONS = {
    'z': ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    '-z': ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
    'y': ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    '-y': ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    'x': ((0, 0, -1), (0, 1, 0), (1, 0, 0)),
    '-x': ((0, 0, 1), (0, 1, 0), (-1, 0, 0)),
}


@dataclass(frozen=True)
class ObjectCard:
    """What is known of an object in the library.

    Attributes:
        name: object id.
        source: the file it was made of.
        scale: factor from the file's unit to metres.
        up: axis of the file that became z.
        made_from: ``mesh``, ``repaired mesh`` or ``cloud``.
        size: extents along x, y, z, metres.
        volume: of the solid, cubic metres.
        num_triangles: of the stored mesh.
    """

    name: str
    source: str
    scale: float
    up: str
    made_from: str
    size: tuple[float, float, float]
    volume: float
    num_triangles: int


@dataclass(frozen=True, eq=False)
class PreparedObject:
    """An object that was made fit for use, not yet stored.

    Attributes:
        mesh: watertight, metres, z up, the file's origin kept.
        card: what is known of it.
    """

    mesh: TriangleMesh
    card: ObjectCard


def prepare_object(
    path: Path,
    *,
    name: str | None = None,
    scale: float | None = None,
    size: float | None = None,
    up: str = 'z',
) -> PreparedObject:
    """Reads a model file and makes it a watertight mesh in metres with z up.

    The origin stays where it is, so that poses of a tracker that uses the same file stay right
    as long as neither scale nor up axis is changed.

    Args:
        path: ply, pcd, obj, stl or off; a cloud must cover the whole surface.
        name: object id; by default the file's name.
        scale: factor to metres; 1 when neither it nor ``size`` is given.
        size: instead of ``scale``: what the largest side should be, metres.
        up: axis of the file that points up, one of ``UP_AXES``.

    Raises:
        ObjectSizeError: when the object would be far too large or small.
        ConfigError: for a bad name, scale, size or axis.
        CloudFormatError: when the file cannot be read.
        InvalidSceneError: when it holds no solid.
    """
    name = checked_name(path.stem if name is None else name)
    if up not in UP_AXES:
        raise ConfigError(f'up axis {up!r} is none of {", ".join(UP_AXES)}')
    if scale is not None and size is not None:
        raise ConfigError('give either a scale or a size, not both')
    for title, value in (('scale', scale), ('size', size)):
        if value is not None and not (np.isfinite(value) and value > 0.0):
            raise ConfigError(f'the {title} must be positive, got {value:g}')
    mesh, points = load_object_model(path, check_units=False)
    surface = points if mesh is None else mesh.vertices
    extent = float(np.ptp(surface, axis=0).max())
    factor = size / extent if size is not None else (1.0 if scale is None else scale)
    check_extent(path.name, extent * factor, on_purpose=scale is not None or size is not None)
    rotation = factor * np.array(_ROTATIONS[up], dtype=np.float64)
    if mesh is None:
        solid, made_from = solid_from_cloud(_turned(points, rotation)), 'cloud'
    else:
        turned = TriangleMesh(_turned(mesh.vertices, rotation), mesh.triangles)
        solid = watertight(turned)
        made_from = 'mesh' if solid is turned else 'repaired mesh'
    return PreparedObject(solid, _card_of(solid, name, path, factor, up, made_from))


class OwnObjects:
    """A folder of a person's own objects: ``NAME.ply`` each, with a card ``NAME.json``.

    It can be given to perception as ``models_path``, to ``relations replay`` as ``--models``.

    Args:
        folder: made by the first :meth:`add`; below XDG_DATA_HOME by default.
    """

    def __init__(self, folder: Path | str | None = None) -> None:
        self.folder = default_objects_folder() if folder is None else Path(folder)

    def add(self, prepared: PreparedObject, *, replace: bool = False) -> Path:
        """Stores an object; returns its mesh file.

        Raises:
            ObjectExistsError: when the name is taken and is not to be replaced.
        """
        card = prepared.card
        path = self.mesh_path(card.name)
        if path.exists() and not replace:
            raise ObjectExistsError(
                f'there is an object {card.name!r} in {self.folder} already; use --replace, or '
                'another --name'
            )
        save_mesh(path, prepared.mesh)
        with atomic_write(path.with_suffix(_CARD)) as temporary:
            temporary.write_text(json.dumps(asdict(card), indent=2) + '\n')
        return path

    def names(self) -> tuple[str, ...]:
        """All object ids, sorted."""
        return tuple(sorted(path.stem for path in self.folder.glob(f'*{_CARD}')))

    def card(self, name: str) -> ObjectCard:
        """What is known of an object.

        Raises:
            UnknownObjectError: when there is none of that name.
            CloudFormatError: when its card is damaged.
        """
        path = self.mesh_path(name).with_suffix(_CARD)
        if name not in self.names():
            known = ', '.join(repr(other) for other in self.names()) or 'nothing yet'
            raise UnknownObjectError(
                f'no object {name!r} in {self.folder}; there is {known}; '
                'relations objects add FILE adds one'
            )
        try:
            content = json.loads(path.read_text())
            content['size'] = tuple(content['size'])
            return ObjectCard(**{field.name: content[field.name] for field in fields(ObjectCard)})
        except (ValueError, KeyError, TypeError) as error:
            raise CloudFormatError(
                f'{path} is damaged ({error}); add the object again with --replace'
            ) from None

    def mesh_path(self, name: str) -> Path:
        """File of an object's mesh, whether it is there or not."""
        return self.folder / f'{name}.ply'

    def preview_path(self, name: str) -> Path:
        """File of an object's picture, whether it is there or not."""
        return self.folder / PREVIEWS / f'{name}.png'


def default_objects_folder() -> Path:
    """Where own objects are kept unless told otherwise: below XDG_DATA_HOME."""
    return data_path('objects')


def checked_name(name: str) -> str:
    """The name, if it can be an object id and a file's name.

    Raises:
        ConfigError: saying what would do.
    """
    if _NAME.fullmatch(name):
        return name
    better = re.sub(r'[^A-Za-z0-9-]+', '_', name).strip('_-').lower()[:64] or 'object'
    raise ConfigError(
        f'an object cannot be called {name!r}: letters, digits, _ and - will do; '
        f'use --name {better}'
    )


def _turned(points: NDArray[np.float32], matrix: NDArray[np.float64]) -> NDArray[np.float32]:
    turned: NDArray[np.float64] = points.astype(np.float64) @ matrix.T
    return turned.astype(np.float32)


def _card_of(
    mesh: TriangleMesh, name: str, path: Path, scale: float, up: str, made_from: str
) -> ObjectCard:
    corners = mesh.vertices[mesh.triangles].astype(np.float64)
    volume = np.einsum('ij,ij->', corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    size = [round(float(length), 6) for length in np.ptp(mesh.vertices, axis=0)]
    return ObjectCard(
        name, path.name, scale, up, made_from, (size[0], size[1], size[2]), float(volume),
        len(mesh.triangles),
    )  # fmt: skip
