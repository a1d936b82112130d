"""What the judge measures on a scene, with the full meshes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import InvalidSceneError, Pose, Scene, SceneObject
from spatial_relations_ros.evaluation.judging.footing import Footing, footing_of
from spatial_relations_ros.evaluation.judging.outline import OutlineOffset, outline_offset
from spatial_relations_ros.evaluation.judging.solid import Solid, solid_of

FloatArray = NDArray[np.float64]

CONTACT_GAP = 0.003

_NUM_ENCLOSED_SAMPLES = 1500
_NEAR = 0.03
_CLEAR_OF_WALL = 5e-4


@dataclass(frozen=True, eq=False)
class Body:
    """A solid at its pose.

    Attributes:
        solid: the mesh and what was measured on it.
        world_from_object: its pose.
        points: (N, 3) of its surface, world.
    """

    solid: Solid
    world_from_object: Pose
    points: FloatArray

    @staticmethod
    def of(item: SceneObject) -> Body:
        """The body of a scene's object.

        Raises:
            InvalidSceneError: when the object has no mesh.
        """
        if item.mesh is None:
            raise InvalidSceneError(
                f'{item.object_id} has no mesh; the judge needs watertight meshes of both objects'
            )
        solid = solid_of(item.mesh)
        points = item.world_from_object.apply(solid.surface_points)
        return Body(solid, item.world_from_object, points)

    @property
    def bottom(self) -> float:
        """Height of the lowest point, metres."""
        return float(self.points[:, 2].min())

    @property
    def top(self) -> float:
        """Height of the highest point, metres."""
        return float(self.points[:, 2].max())

    @property
    def centre_of_mass(self) -> FloatArray:
        """(3,), world."""
        return self.world_from_object.apply(self.solid.centre_of_mass)

    @cached_property
    def down(self) -> FloatArray:
        """Towards the ground in the nearest way to stand on it, (3,) unit vector, world."""
        if not len(self.solid.rest_directions):
            return np.array([0.0, 0.0, -1.0])
        directions = self.solid.rest_directions @ self.world_from_object.rotation.T
        nearest: FloatArray = directions[int(np.argmin(directions[:, 2]))]
        return nearest

    @property
    def tilt_rad(self) -> float:
        """Angle to the nearest way in which it stands on level ground."""
        return float(np.arccos(np.clip(-self.down[2], -1.0, 1.0)))

    @property
    def diameter(self) -> float:
        """Of the smallest ball about the centre of mass that holds it, metres."""
        return 2.0 * float(np.linalg.norm(self.points - self.centre_of_mass, axis=1).max())

    def to_object(self, points: FloatArray) -> FloatArray:
        """World points (P, 3) in the object's frame."""
        return self.world_from_object.inverse().apply(points)


@dataclass(frozen=True, eq=False)
class Measures:
    """A scene in numbers; lengths in metres, heights above the table.

    Attributes:
        clearance: smallest signed distance between the surfaces; negative in penetration.
        contact_points: (C, 3) where the objects touch, metres, world with the table at z = 0.
        base_bottom, relative_bottom: of the lowest points.
        base_height, relative_height: vertical extents.
        base_diameter, relative_diameter: of the bounding balls about the mass centres.
        offset: (3,) from the base's centre of mass to that of the relative.
        outline: how far the relative is beside the base, seen from above.
        base_tilt_rad, tilt_rad: angles to the nearest way to stand on level ground.
        enclosed: share of the relative's surface, where it is free of the base, that is in the
            base's hollow.
        sunk: the same in depth: how much of the hollow's depth, or of the relative's reach along
            the opening where that is less, is below the rim.
        hollow_depth: of the base's hollow as a share of its width; 0 without a hollow.
        opening_up: upward component of the direction out of the hollow; None without a hollow.
        footing: how the relative's foot lies on what carries it; None when it is not above.
        penetration_of_table: how far the lower of the two is below the table.
    """

    clearance: float
    contact_points: FloatArray
    base_bottom: float
    relative_bottom: float
    base_height: float
    relative_height: float
    base_diameter: float
    relative_diameter: float
    offset: FloatArray
    outline: OutlineOffset
    base_tilt_rad: float
    tilt_rad: float
    enclosed: float
    sunk: float
    hollow_depth: float
    opening_up: float | None
    footing: Footing | None
    penetration_of_table: float

    @property
    def touches(self) -> bool:
        """Whether the objects touch."""
        return len(self.contact_points) > 0

    @property
    def seat_height(self) -> float:
        """Mean height of the contacts, or of the relative's middle if that is lower."""
        if not self.touches:
            return self.relative_bottom
        middle = self.relative_bottom + 0.5 * self.relative_height
        return min(middle, float(self.contact_points[:, 2].mean()))

    @property
    def contact_heights(self) -> tuple[float, float] | None:
        """Lowest and highest contact, metres above the table."""
        if not self.touches:
            return None
        return float(self.contact_points[:, 2].min()), float(self.contact_points[:, 2].max())


def measure_scene(
    scene: Scene, table_height: float | None = None, *, contact_gap: float = CONTACT_GAP
) -> Measures:
    """Measures base and relative of a scene.

    Args:
        scene: both objects with watertight meshes.
        table_height: z of the table in the scene's world, metres; the lowest point of both
            objects by default.
        contact_gap: points that are no farther from the other object touch it, metres.

    Raises:
        InvalidSceneError: when a mesh is missing, or encloses nothing.
    """
    base, relative = Body.of(scene.base), Body.of(scene.relative)
    if table_height is None:
        table_height = min(base.bottom, relative.bottom)
    clearance, contacts = _contacts(base, relative, contact_gap)
    hollow = base.solid.hollow
    enclosed, sunk, opening_up = _enclosure(base, relative)
    contacts = contacts - [0.0, 0.0, table_height]
    return Measures(
        clearance=clearance,
        contact_points=contacts,
        base_bottom=base.bottom - table_height,
        relative_bottom=relative.bottom - table_height,
        base_height=base.top - base.bottom,
        relative_height=relative.top - relative.bottom,
        base_diameter=base.diameter,
        relative_diameter=relative.diameter,
        offset=relative.centre_of_mass - base.centre_of_mass,
        outline=outline_offset(base.points, relative.points),
        base_tilt_rad=base.tilt_rad,
        tilt_rad=relative.tilt_rad,
        enclosed=enclosed,
        sunk=sunk,
        hollow_depth=0.0 if hollow is None else hollow.depth / hollow.width,
        opening_up=opening_up,
        footing=footing_of(base.points, relative.points, down=relative.down, gap=contact_gap),
        penetration_of_table=max(0.0, table_height - min(base.bottom, relative.bottom)),
    )


def _contacts(base: Body, relative: Body, gap: float) -> tuple[float, FloatArray]:
    """The smallest signed distance, and the points (C, 3) of either within the contact gap."""
    smallest, touching = np.inf, []
    for source, target in ((base, relative), (relative, base)):
        local = target.to_object(source.points)
        vertices = target.solid.mesh.vertices
        low, high = vertices.min(axis=0) - _NEAR, vertices.max(axis=0) + _NEAR
        near = np.flatnonzero(((local > low) & (local < high)).all(axis=1))
        if not len(near):
            continue
        distances = target.solid.signed_distance(local[near])
        smallest = min(smallest, float(distances.min()))
        touching.append(source.points[near[distances < gap]])
    if smallest > _NEAR:
        # The nearest points may lie outside of the boxes.
        local = relative.to_object(base.points)
        smallest = float(relative.solid.signed_distance(local).min())
    return smallest, np.concatenate(touching) if touching else np.zeros((0, 3))


def _enclosure(base: Body, relative: Body) -> tuple[float, float, float | None]:
    """Share of the relative in the base's hollow, how deep it sits, where the opening looks."""
    hollow = base.solid.hollow
    if hollow is None:
        return 0.0, 0.0, None
    local = base.to_object(relative.points)
    along = local @ hollow.opening
    length = float(np.ptp(along))
    # The even samples come first; those along edges would count edges more.
    samples = local[:: max(1, len(local) // _NUM_ENCLOSED_SAMPLES)]
    # What lies on a wall's outer face is a hair's breadth within the wall, and so surrounded.
    samples = samples[base.solid.signed_distance(samples) > _CLEAR_OF_WALL]
    enclosed = float(hollow.encloses(base.solid.rays, samples).mean()) if len(samples) else 0.0
    deep = min(hollow.depth, length)
    sunk = float(np.clip((hollow.rim - along.min()) / max(deep, 1e-4), 0.0, 1.0))
    opening_up = float(base.world_from_object.rotation[2] @ hollow.opening)
    return enclosed, sunk if enclosed > 0.0 else 0.0, opening_up
