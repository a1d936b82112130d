"""Tilting what was let down until three contacts carry it, and how steady it then is.

Seen from a body, what lies below it is a field of vertical gaps. Of all small tilts the one that
brings the centre of mass lowest presses the body against three points whose triangle holds the
centre of mass: the facet of the gaps' lower convex hull that is below it. The neighbouring facets
say what happens on a tilted table: on flat ground nothing, on round ground the body rolls.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from spatial_relations_ros.placement.body import FloatArray, Placed
from spatial_relations_ros.placement.contact import travel_to_contact
from spatial_relations_ros.placement.ray_casting import as_tensor
from spatial_relations_ros.placement.resting import DOWN, UP, about_axis

# What tilts by 10 degrees or more leans.
MAX_TIP_RAD = float(np.deg2rad(9.5))
# On a table that is tilted by some degrees a steady body turns by no more than this.
MAX_ROLL_RAD = float(np.deg2rad(3.0))
_LIFT = 0.012
_NUM_STEPS = 8
_DONE_RAD = float(np.deg2rad(0.15))
_MOST_LEVEL = 0.3
_FLAT = 1e-6
_ASKEW = 0.05
_NUM_AROUND = 8
_NUM_SWAYS = 4


@dataclass(frozen=True, eq=False)
class Ground:
    """What is below a body, as planes that it could lie on.

    Attributes:
        planes: (F, 3) slope in x, slope in y and height at the centre of mass of each facet of
            the lower hull of the gaps; heights are gaps, metres.
        height: of the centre of mass above what carries it, metres.
        reach: (48, 2)-like corners (H, 2) of the hull seen from above, from the centre of mass.
    """

    planes: FloatArray
    height: float
    corners: FloatArray

    @staticmethod
    def below(moving: Placed, fixed: Placed) -> Ground | None:
        """Measures the gaps from a body to another one and to the table z = 0.

        Args:
            moving: above whatever is below it, touching it at most.
            fixed: the other body.
        """
        gaps = _vertical_gaps(moving, fixed)
        if len(gaps) < 4:
            return None
        centre = moving.centre_of_mass()
        gaps[:, :2] -= centre[:2]
        try:
            hull = ConvexHull(gaps)
            # The corners seen from above are corners of the whole.
            outline = ConvexHull(gaps[hull.vertices, :2])
        except QhullError:
            return None
        lower = hull.equations[hull.equations[:, 2] < -_FLAT]
        planes = -lower[:, [0, 1, 3]] / lower[:, 2:3]
        bottom = float(moving.world_vertices[:, 2].min())
        return Ground(planes, float(centre[2]) - bottom, outline.equations)

    def facet(self, offset: FloatArray) -> FloatArray | None:
        """The plane (3,) below a point (2,) from the centre of mass; None beyond the ground."""
        if (self.corners[:, :2] @ offset + self.corners[:, 2] > 0.0).any():
            return None
        heights = self.planes[:, :2] @ offset + self.planes[:, 2]
        plane: FloatArray = self.planes[int(heights.argmax())]
        return plane

    def roll_rad(self, tilt_rad: float) -> float:
        """How far the body turns when the table is tilted, at most over directions.

        Infinite for what falls, as it does without a tilt where it is not carried. The centre of
        mass goes to the low side, first with the tilt and then with the turn that this causes.
        """
        level = self.facet(np.zeros(2))
        if level is None or float(np.hypot(level[0], level[1])) > _ASKEW:
            return np.inf
        most = 0.0
        for angle in np.arange(_NUM_AROUND) * (2.0 * np.pi / _NUM_AROUND):
            downhill = np.array([np.cos(angle), np.sin(angle)])
            turn = np.zeros(2)
            for _ in range(_NUM_SWAYS):
                sway = self.height * (np.tan(tilt_rad) * downhill + turn)
                plane = self.facet(sway)
                if plane is None:
                    return np.inf
                turn = plane[:2] - level[:2]
            most = max(most, float(np.linalg.norm(turn)))
        return most


def tipped(moving: Placed, fixed: Placed, max_angle_rad: float = MAX_TIP_RAD) -> Placed | None:
    """Lets a body down onto another one and the table, and lets it tilt until it is carried.

    Args:
        moving: above the other body, or touching it from above.
        fixed: the other body.
        max_angle_rad: None is returned for what would tilt by more.

    Returns:
        None as well when it finds no rest.
    """
    start = moving.rotation
    for _ in range(_NUM_STEPS):
        raised = moving.moved(UP * _LIFT)
        ground = Ground.below(raised, fixed)
        plane = None if ground is None else ground.facet(np.zeros(2))
        if plane is None:
            return None
        slope = float(np.hypot(plane[0], plane[1]))
        moving = _tilted(raised, plane)
        cosine = 0.5 * (float(np.trace(moving.rotation @ start.T)) - 1.0)
        if np.arccos(np.clip(cosine, -1.0, 1.0)) > max_angle_rad:
            return None
        moving = _let_down(moving, fixed)
        if np.arctan(slope) < _DONE_RAD:
            return moving
    return None


def _tilted(raised: Placed, plane: FloatArray) -> Placed:
    """Turned so that a plane of gaps becomes level, about the point that is below its centre."""
    slope = float(np.hypot(plane[0], plane[1]))
    if slope < 1e-9:
        return raised
    axis = np.array([-plane[1], plane[0], 0.0]) / slope
    centre = raised.centre_of_mass()
    pivot = np.array([centre[0], centre[1], float(raised.world_vertices[:, 2].min())])
    turned = raised.moved(-pivot).turned(about_axis(axis, float(np.arctan(slope))))
    return turned.moved(pivot + UP * 0.5 * _LIFT)


def _let_down(moving: Placed, fixed: Placed) -> Placed:
    to_table = float(moving.world_vertices[:, 2].min())
    return moving.moved(DOWN * min(travel_to_contact(moving, fixed, DOWN), to_table))


def _vertical_gaps(moving: Placed, fixed: Placed) -> FloatArray:
    """Points (N, 3): where seen from above, and the way down there to the first contact."""
    faces_down = moving.world_normals()[:, 2] < _MOST_LEVEL
    faces_up = fixed.world_normals()[:, 2] > -_MOST_LEVEL
    own, other = moving.world_points[faces_down], fixed.world_points[faces_up]
    low, high = own[:, :2].min(axis=0), own[:, :2].max(axis=0)
    other = other[((other[:, :2] > low) & (other[:, :2] < high)).all(axis=1)]
    down = np.minimum(_travel(own, DOWN, fixed), own[:, 2])
    up = _travel(other, UP, moving)
    met = np.isfinite(up)
    return np.concatenate(
        [np.column_stack([own[:, :2], down]), np.column_stack([other[met, :2], up[met]])]
    )


def _travel(origins: FloatArray, direction: FloatArray, target: Placed) -> FloatArray:
    rays = np.empty((len(origins), 6), dtype=np.float32)
    rays[:, :3] = target.to_object(origins)
    rays[:, 3:] = target.rotation.T @ direction
    hits = target.body.surface.cast_rays(as_tensor(rays))['t_hit'].numpy()
    return np.asarray(hits, dtype=np.float64)
