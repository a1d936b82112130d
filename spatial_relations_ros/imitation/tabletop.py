"""The objects to place as solids on a table, in the frame that placing expects."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import Pose
from spatial_relations_ros.imitation.shape import Shape
from spatial_relations_ros.imitation.solids import Solid, hand_scale, solid_of
from spatial_relations_ros.placement.body import Placed


@dataclass(frozen=True, eq=False)
class Tabletop:
    """Base and relative on the table z = 0, with the base's middle above the origin.

    Attributes:
        solids: of base and relative.
        origin: (3,) of the frame in the world, metres.
    """

    solids: tuple[Solid, Solid]
    origin: NDArray[np.float64]

    @staticmethod
    def of(shapes: tuple[Shape, Shape], world_from_base: Pose, table_height: float) -> Tabletop:
        """Prepares two shapes; slow the first time that a mesh is seen.

        Args:
            shapes: of base and relative.
            world_from_base: where the base is.
            table_height: of the table in the world, metres.
        """
        scale = hand_scale(shapes)
        base, relative = (solid_of(shape, scale) for shape in shapes)
        middle = world_from_base.apply(base.rotation.T @ base.centre)
        return Tabletop((base, relative), np.array([middle[0], middle[1], table_height]))

    def placed(self, role: int, world_from_object: Pose) -> Placed:
        """The body of base (0) or relative (1) where its object is."""
        return self.solids[role].placed(world_from_object, self.origin)

    def pose(self, role: int, placed: Placed) -> Pose:
        """World_from_object of base (0) or relative (1) where its body is."""
        return self.solids[role].pose(placed, self.origin)
