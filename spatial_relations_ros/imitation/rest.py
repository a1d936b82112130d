"""Bringing candidates to rest, and whether they stay there."""

from __future__ import annotations

import math

import numpy as np

from spatial_relations_ros.imitation.candidates import Candidate
from spatial_relations_ros.imitation.proposals import Proposal
from spatial_relations_ros.imitation.statics import rest_together, rests
from spatial_relations_ros.imitation.targets import Targets
from spatial_relations_ros.placement.body import Placed
from spatial_relations_ros.placement.resting import UP, about_z
from spatial_relations_ros.placement.settling import Manner, settle
from spatial_relations_ros.placement.stability import TABLE_TILT_RAD
from spatial_relations_ros.placement.tipping import MAX_ROLL_RAD, Ground, tipped

_STEADY_TILT_RAD = math.radians(8.0)
_HAIR = 3e-4


class Rest:
    """The rest of one request's candidates."""

    def __init__(self, targets: Targets, *, upright: bool = False) -> None:
        """Begins a request.

        Args:
            targets: where the objects may go.
            upright: whether they are turned about the vertical only.
        """
        self._targets, self._upright = targets, upright
        # Measured once: ranking and checks ask for it again.
        self._grounds: dict[Proposal, Ground | None] = {}

    def settled(self, candidate: Candidate, *, exact: bool = True) -> Candidate | None:
        """The candidate brought to rest in its manner; its distance is not measured again.

        Args:
            candidate: nearly at rest.
            exact: with all points of contact rather than with a quarter of them.

        Returns:
            None when it cannot rest in that manner.
        """
        base, relative = (
            self._targets.tabletop.placed(role, pose) for role, pose in enumerate(candidate.poses)
        )
        if self._upright:
            base, relative = (
                _upright(placed, now)
                for placed, now in zip((base, relative), self._targets.now, strict=True)
            )
        if self._targets.movable[0]:
            base = base.on_table()
        if not exact:
            base, relative = base.coarse(), relative.coarse()
        manners = (candidate.manner,) if candidate.manner else (Manner.LOWERED, Manner.DROPPED)
        for manner in manners:
            placed = settle(manner, relative, base)
            if placed is not None:
                break
        else:
            return None
        if exact and manner is Manner.DROPPED and not self._upright:
            placed = tipped(relative, base) or tipped(placed, base) or placed
        cell = candidate.proposal.cell if candidate.proposal else 0
        proposal = Proposal(base, placed, manner, cell)
        poses = self._targets.poses(proposal)
        if poses is None:
            return None
        return Candidate(poses, candidate.distance, candidate.cost, manner, proposal)

    def stays(self, candidate: Candidate, *, tilt_rad: float = TABLE_TILT_RAD) -> bool:
        """Whether friction holds a placed candidate where it is, on a table tilted so far."""
        if candidate.proposal is None:
            return False
        base, relative = candidate.proposal.base, candidate.proposal.relative
        if all(self._targets.movable):
            return rest_together(base, relative, tilt_rad=tilt_rad)
        return rests(relative, base, tilt_rad=tilt_rad) and (
            not self._targets.movable[0] or rests(base, relative, tilt_rad=tilt_rad)
        )

    def is_steady(self, candidate: Candidate) -> bool:
        """Whether it stays on a table that is tilted more, and does not roll there."""
        if not self.stays(candidate, tilt_rad=_STEADY_TILT_RAD):
            return False
        ground = self._ground(candidate)
        return ground is None or ground.roll_rad(TABLE_TILT_RAD) <= MAX_ROLL_RAD

    def rolls(self, candidate: Candidate) -> bool:
        """Whether it would roll aside on a level table already."""
        ground = self._ground(candidate)
        return ground is not None and ground.roll_rad(0.0) > MAX_ROLL_RAD

    def _ground(self, candidate: Candidate) -> Ground | None:
        """What is below something that was let down; None for what rests in other manners."""
        if candidate.proposal is None or candidate.manner is not Manner.DROPPED:
            return None
        proposal = candidate.proposal
        if proposal not in self._grounds:
            raised = proposal.relative.moved(_HAIR * UP)
            self._grounds[proposal] = Ground.below(raised, proposal.base)
        return self._grounds[proposal]


def _upright(placed: Placed, now: Placed) -> Placed:
    """The body as it stands now, at the place and heading of a placed one."""
    turn = placed.rotation @ now.rotation.T
    yaw = about_z(float(np.arctan2(turn[1, 0], turn[0, 0])))
    return Placed(placed.body, yaw @ now.rotation, placed.translation)
