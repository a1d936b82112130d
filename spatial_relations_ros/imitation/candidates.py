"""Placements that were compared with the demonstration."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from spatial_relations_ros.core import Pose
from spatial_relations_ros.imitation.proposals import Proposal
from spatial_relations_ros.placement.settling import Manner

_SAME_SHIFT = 0.02
# Of half of the angle, as quaternions are compared.
_SAME_TURN_COSINE = math.cos(math.radians(2.0))

PosePair = tuple[Pose, Pose]


@dataclass(frozen=True, eq=False)
class Candidate:
    """A placement that was compared with the demonstration.

    Attributes:
        poses: world_from_object of base and relative.
        distance: under the metric, over one heading.
        cost: distance and penalties; smaller is better.
        manner: in which the pair rests; None for poses that were not placed by a rule.
        proposal: it came from, on the table; None likewise.
    """

    poses: PosePair
    distance: float
    cost: float
    manner: Manner | None = None
    proposal: Proposal | None = None


def unlike(candidates: list[Candidate], extent: float) -> list[Candidate]:
    """Cheapest first, without those that all but repeat a cheaper one."""
    ranked = sorted(candidates, key=lambda candidate: candidate.cost)
    shifts = np.array([[pose.translation for pose in c.poses] for c in ranked])
    turns = np.array([[pose.quat_wxyz for pose in c.poses] for c in ranked])
    kept: list[int] = []
    for idx in range(len(ranked)):
        near = np.linalg.norm(shifts[kept] - shifts[idx], axis=-1) < _SAME_SHIFT * extent
        cosines = np.abs(np.einsum('krq,rq->kr', turns[kept], turns[idx]))
        if not (near & (cosines > _SAME_TURN_COSINE)).all(axis=1).any():
            kept.append(idx)
    return [ranked[idx] for idx in kept]
