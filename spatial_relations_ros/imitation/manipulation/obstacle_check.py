"""Whether a placed body is clear of obstacles, exactly and in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from spatial_relations_ros.imitation.contact import Body, reach_through
from spatial_relations_ros.imitation.feasibility import MAX_PENETRATION
from spatial_relations_ros.imitation.manipulation.nearness import lowest_distance, signed_gap
from spatial_relations_ros.imitation.manipulation.obstacles import Obstacle, Points

# Points of one obstacle that are so near each other are taken to have surface between them.
_CHORD_LENGTHS = (0.008, 0.012)
_MAX_CHORDS = 4096
_MIN_CHORDS = 3
_MIN_CUT = 0.002


@dataclass(frozen=True)
class ObstacleCheck:
    """What obstacles say about one body's place.

    Attributes:
        penetration: deepest overlap, metres.
        violations: in words.
    """

    penetration: float
    violations: tuple[str, ...]


def check_obstacles(name: str, body: Body, obstacles: Sequence[Obstacle]) -> ObstacleCheck:
    """Checks the overlap of a body with obstacles; up to 5 mm are allowed, as elsewhere.

    A cloud overlaps by how deep its points are in the body. Walls thinner than twice the 5 mm are
    watched another way: neighbouring points of the cloud must not lie on both sides of them.
    """
    points = body.world_points
    low, high = points.min(axis=0), points.max(axis=0)
    deepest, violations = 0.0, []
    for obstacle in obstacles:
        if (obstacle.box[1] < low).any() or (obstacle.box[0] > high).any():
            continue
        solid = obstacle.body
        if solid is None:
            near = obstacle.points_in(low, high)
            depth = max(-lowest_distance(body, near), 0.0)
            cut = 0.0 if depth > MAX_PENETRATION else _cut(body, obstacle, low, high)
        else:
            depth = max(-signed_gap(body, solid), 0.0)
            cut = 0.0 if depth > MAX_PENETRATION else reach_through(body, solid)
            cut = cut if cut > MAX_PENETRATION else 0.0
        if depth > MAX_PENETRATION:
            violations.append(f'{name} would overlap {obstacle.name} by {depth * 1e3:.0f} mm')
        elif cut:
            violations.append(f'{name} would cut into {obstacle.name} by {cut * 1e3:.0f} mm')
        deepest = max(deepest, depth, cut)
    return ObstacleCheck(deepest, tuple(violations))


def _cut(body: Body, obstacle: Obstacle, low: Points, high: Points) -> float:
    """How far a cloud at least reaches through a wall of the body, metres; 0 when it does not."""
    short, long = _CHORD_LENGTHS
    points = obstacle.points_in(low - long, high + long)
    if len(points) < 2:
        return 0.0
    pairs = KDTree(points).query_pairs(long, output_type='ndarray')
    lengths = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    pairs = pairs[lengths > short]
    pairs = pairs[:: max(1, len(pairs) // _MAX_CHORDS)]
    chords = body.pose.inverse().apply(points[pairs]).astype(np.float32)
    crossing = chords[body.shape.passes(chords)] if len(chords) else chords
    if len(crossing) < _MIN_CHORDS:
        return 0.0
    ends = body.shape.signed_distance(crossing.reshape(-1, 3)).reshape(-1, 2).min(axis=1)
    beyond = ends[ends > _MIN_CUT]
    return float(beyond.max()) if len(beyond) >= _MIN_CHORDS else 0.0
