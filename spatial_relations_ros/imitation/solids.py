"""Shapes as solids that can be placed: centred, opening upwards, of a size that one can hold."""

from __future__ import annotations

import weakref
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from spatial_relations_ros.core import Pose, TriangleMesh
from spatial_relations_ros.imitation.shape import Shape
from spatial_relations_ros.placement.body import Body, Placed
from spatial_relations_ros.placement.model import ObjectModel
from spatial_relations_ros.placement.openings import find_opening

FloatArray = NDArray[np.float64]

MAX_TRIANGLES = 20_000
_DENSITY = 1000.0  # of any material: the balance of one body does not depend on it
# Contact tolerances are meant for things that one takes in the hand; others are scaled to this.
_HAND_SIZES = (0.04, 1.5)
_HAND_SIZE = 0.3
_MOST_SCALES = 4


@dataclass(frozen=True, eq=False)
class Solid:
    """A shape prepared for placing.

    Attributes:
        body: centred on its bounding box, with its opening, if any, towards +z; scaled.
        rotation: (3, 3), model from object.
        centre: (3,) of the bounding box in the turned frame, metres.
        scale: lengths of the body over metres.
    """

    body: Body
    rotation: FloatArray
    centre: FloatArray
    scale: float

    @staticmethod
    def of(mesh: TriangleMesh, scale: float) -> Solid:
        """Measures a watertight mesh: opening, ways to rest, points of contact."""
        mesh = _reduced(mesh)
        found = find_opening(mesh)
        rotation = np.eye(3) if found is None else found.rotation
        vertices = mesh.vertices.astype(np.float64) @ rotation.T
        centre = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
        opening = None if found is None else found.opening.moved(-centre).scaled(scale)
        centred = TriangleMesh((scale * (vertices - centre)).astype(np.float32), mesh.triangles)
        model = ObjectModel('', '', centred, {}, opening, _DENSITY)
        return Solid(Body.of(model), rotation, centre, scale)

    def placed(self, world_from_object: Pose, origin: Sequence[float] | FloatArray) -> Placed:
        """The body where its object is, in a frame with the world's axes at an origin (3,)."""
        rotation = world_from_object.rotation @ self.rotation.T
        translation = rotation @ self.centre + world_from_object.translation - np.asarray(origin)
        return Placed(self.body, rotation, self.scale * translation)

    def pose(self, placed: Placed, origin: FloatArray) -> Pose:
        """World_from_object of a placed body; any number of contact points will do."""
        translation = placed.translation / self.scale + origin
        return Pose.from_rotation(
            placed.rotation @ self.rotation, translation - placed.rotation @ self.centre
        )


def hand_scale(shapes: Iterable[Shape]) -> float:
    """Factor that brings objects to a size for which contact tolerances are meant; mostly 1."""
    extent = sum(float(np.linalg.norm(np.ptp(shape.points, axis=0))) for shape in shapes)
    return 1.0 if _HAND_SIZES[0] < extent < _HAND_SIZES[1] else _HAND_SIZE / extent


_solids: weakref.WeakKeyDictionary[Shape, dict[float, Solid]] = weakref.WeakKeyDictionary()


def solid_of(shape: Shape, scale: float) -> Solid:
    """The solid of a shape, made once; a tenth of a second the first time.

    Of a shape beside others of which each asks for another scale the last few are kept.
    """
    known = _solids.setdefault(shape, {})
    if scale not in known:
        while len(known) >= _MOST_SCALES:
            del known[next(iter(known))]
        known[scale] = Solid.of(shape.mesh, scale)
    return known[scale]


def _reduced(mesh: TriangleMesh) -> TriangleMesh:
    """Fewer triangles, where there are more than contact queries can use."""
    if len(mesh.triangles) <= MAX_TRIANGLES:
        return mesh
    full = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(mesh.vertices.astype(np.float64)),
        o3d.utility.Vector3iVector(mesh.triangles),
    )
    reduced = full.simplify_quadric_decimation(MAX_TRIANGLES)
    return TriangleMesh(
        np.asarray(reduced.vertices, dtype=np.float32),
        np.asarray(reduced.triangles, dtype=np.int32),
    )
