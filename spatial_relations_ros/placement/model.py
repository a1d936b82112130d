"""What is known about a generated object."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import TriangleMesh
from spatial_relations_ros.placement.mass import MassProperties, mass_properties
from spatial_relations_ros.placement.rest_poses import RestPose, find_rest_poses

FloatArray = NDArray[np.float64]

SHALLOW_DEPTH = 0.035


@dataclass(frozen=True)
class Opening:
    """The cavity of a container, in the object frame, metres; it opens towards +z.

    Attributes:
        rim_half_size: half of the clear width in x and y at the rim.
        floor_half_size: half of the clear width in x and y at the floor.
        rim_z: height of the rim.
        floor_z: height of the floor.
        is_round: whether the clear section is an ellipse rather than a rectangle.
        centre: x and y of the cavity's axis.
    """

    rim_half_size: tuple[float, float]
    floor_half_size: tuple[float, float]
    rim_z: float
    floor_z: float
    is_round: bool
    centre: tuple[float, float] = (0.0, 0.0)

    @property
    def depth(self) -> float:
        """From rim to floor, metres."""
        return self.rim_z - self.floor_z

    def moved(self, offset: FloatArray) -> Opening:
        """The same opening after the object's vertices were moved by ``offset``."""
        return Opening(
            self.rim_half_size,
            self.floor_half_size,
            self.rim_z + float(offset[2]),
            self.floor_z + float(offset[2]),
            self.is_round,
            (self.centre[0] + float(offset[0]), self.centre[1] + float(offset[1])),
        )

    def scaled(self, factor: float) -> Opening:
        """The same opening of an object that is larger by a factor."""
        return Opening(
            (factor * self.rim_half_size[0], factor * self.rim_half_size[1]),
            (factor * self.floor_half_size[0], factor * self.floor_half_size[1]),
            factor * self.rim_z,
            factor * self.floor_z,
            self.is_round,
            (factor * self.centre[0], factor * self.centre[1]),
        )


@dataclass(frozen=True, eq=False)
class ObjectModel:
    """A household object.

    Its frame has z up in the natural rest and its origin at the centre of the bounding box.

    Attributes:
        name: unique name; without underscores, since scene names join object names by them.
        family: kind of object, one of ``OBJECT_FAMILIES``.
        mesh: watertight surface, metres.
        dimensions: the drawn lengths by name, metres.
        opening: the cavity, for containers (and the hollow of plates and trays).
        density: mass of the material, kg / m^3.
    """

    name: str
    family: str
    mesh: TriangleMesh
    dimensions: Mapping[str, float]
    opening: Opening | None
    density: float

    @cached_property
    def half_extents(self) -> FloatArray:
        """Half of the bounding box, (3,) metres."""
        vertices = self.mesh.vertices.astype(np.float64)
        extents: FloatArray = (vertices.max(axis=0) - vertices.min(axis=0)) / 2.0
        return extents

    @cached_property
    def mass_properties(self) -> MassProperties:
        """Mass and its centre for a body of even density."""
        return mass_properties(self.mesh, density=self.density)

    @cached_property
    def rest_poses(self) -> tuple[RestPose, ...]:
        """All orientations in which the object stands on a table."""
        return find_rest_poses(self.mesh, self.mass_properties.centre)

    @cached_property
    def level_axes(self) -> FloatArray:
        """Directions (K, 3) in its frame that point up when it rests, however narrowly."""
        poses = find_rest_poses(self.mesh, self.mass_properties.centre, min_margin=0.0)
        return np.array([pose.rotation[2] for pose in poses]).reshape(-1, 3)

    @property
    def is_container(self) -> bool:
        """Whether things can be inside of it, rather than on it."""
        return self.opening is not None and self.opening.depth > SHALLOW_DEPTH

    @property
    def is_elongated(self) -> bool:
        """Whether it is clearly longer than wide: it can lean on a rim."""
        lengths = np.sort(self.half_extents)
        return bool(lengths[2] > 1.35 * lengths[1])

    def points(self, num_points: int, rng: np.random.Generator) -> NDArray[np.float32]:
        """Points (num_points, 3) spread uniformly over the surface, object frame."""
        return self.mesh.sample_surface(num_points, rng)
