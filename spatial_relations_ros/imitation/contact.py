"""How far two solids overlap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from spatial_relations_ros.core import Pose
from spatial_relations_ros.imitation.shape import Array, Shape


@dataclass(frozen=True, eq=False)
class Body:
    """A shape at a pose; ``pose`` is world_from_object."""

    shape: Shape
    pose: Pose

    @property
    def world_points(self) -> NDArray[np.float64]:
        """Surface points (2048, 3) in the world frame."""
        return self.pose.apply(self.shape.points)

    @property
    def world_centre_of_mass(self) -> NDArray[np.float64]:
        """Centre of mass (3,) in the world frame."""
        return self.pose.apply(self.shape.centre_of_mass)

    def shifted(self, offset: NDArray[np.float64]) -> Body:
        """The same body moved by an offset (3,) in the world frame."""
        return Body(self.shape, Pose(self.pose.translation + offset, self.pose.quat_wxyz))

    def signed_distance(self, world_points: NDArray[np.floating]) -> Array:
        """Signed distance (N,) of world points (N, 3) to this body, metres."""
        return self.shape.signed_distance(
            self.pose.inverse().apply(world_points).astype(np.float32)
        )


def overlap(first: Body, second: Body) -> float:
    """Deepest overlap of two bodies at their surface points, metres; 0 without one."""
    return max(_depth(first.world_points, second), _depth(second.world_points, first))


def _depth(world_points: NDArray[np.float64], body: Body) -> float:
    """How deep the deepest of points (N, 3) is in a body, metres."""
    shape, local = body.shape, body.pose.inverse().apply(world_points).astype(np.float32)
    coarse = shape.field.sample(torch.from_numpy(local)).numpy()
    # Between its nodes the grid is off by less than its spacing: others cannot be the deepest.
    off = shape.field.spacing
    deepest = local[coarse < min(off, float(coarse.min()) + 2.0 * off)]
    return max(0.0, -float(shape.signed_distance(deepest).min())) if len(deepest) else 0.0


def reach_through(first: Body, second: Body) -> float:
    """How far one body reaches through a wall of the other, metres; 0 when it does not.

    The depth of :func:`overlap` is at most half a wall, so it misses thin walls that cross. Here
    edges of either mesh that pass all through the other count by how far their nearer end is
    from the wall. Estimates from clouds have no edges and are not checked.
    """
    return max(_reach_through(first, second), _reach_through(second, first))


def _reach_through(edged: Body, walled: Body) -> float:
    if not len(edged.shape.edges):
        return 0.0
    walled_from_edged = walled.pose.inverse() @ edged.pose
    ends = walled_from_edged.apply(edged.shape.edges).astype(np.float32)
    passing = ends[walled.shape.passes(ends)]
    if not len(passing):
        return 0.0
    distances = walled.shape.signed_distance(passing.reshape(-1, 3)).reshape(-1, 2)
    return float(distances.min(axis=1).max())


def lowest_point(bodies: Sequence[Body]) -> float:
    """World height of the lowest surface point of bodies, metres."""
    return min(float(body.world_points[:, 2].min()) for body in bodies)
