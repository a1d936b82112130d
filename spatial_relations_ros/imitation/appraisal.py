"""What a placement is worth beside its distance under the metric."""

from __future__ import annotations

from dataclasses import replace

from spatial_relations_ros.imitation.arrangement import (
    arrangement_difference,
    is_alike,
    leans,
    rests_on_other,
)
from spatial_relations_ros.imitation.candidates import Candidate
from spatial_relations_ros.imitation.lean import turned_over
from spatial_relations_ros.imitation.options import ImitationOptions
from spatial_relations_ros.imitation.proposals import Proposal
from spatial_relations_ros.imitation.reaching import Reaching
from spatial_relations_ros.imitation.targets import Targets
from spatial_relations_ros.placement.arrangement import Arrangement

# What does not have to be turned over is left as it stands.
_TURN_WEIGHT = 0.08
# Where nothing leans a person wants that all the more of what shows the relation as well: a mug on
# its side on a tray resembles a squat cup on a plate.
_NEEDLESS_TURN_WEIGHT = 0.8
# What no arm reaches comes after all that one does.
_OUT_OF_REACH = 1.0


class Appraisal:
    """Arrangement, turning over and reach of one request's placements.

    Args:
        targets: of the objects to place.
        reaching: of the arms.
        options: of the request.
        wanted: arrangement of the demonstration, if that is known.
    """

    def __init__(
        self,
        targets: Targets,
        reaching: Reaching,
        options: ImitationOptions,
        wanted: Arrangement | None,
    ) -> None:
        self._targets, self._reaching, self._options = targets, reaching, options
        self._wanted = wanted
        # Measured once: search, ranking and checks ask for them again.
        self._arrangements: dict[Proposal, Arrangement] = {}

    @property
    def needs_foothold(self) -> bool:
        """Whether the relative is to be carried by the base alone, as far as that is known."""
        return self._wanted is None or rests_on_other(self._wanted)

    def penalty(self, candidate: Candidate) -> float:
        """For another arrangement than the demonstration's, turning things over, and reach."""
        if candidate.proposal is None:
            return 0.0
        now, proposal = self._targets.now, candidate.proposal
        penalty = _TURN_WEIGHT * (
            turned_over(now[0].rotation, proposal.base.rotation)
            + turned_over(now[1].rotation, proposal.relative.rotation)
        )
        if self._options.arm is not None and not self._reaching.reaches(candidate.poses):
            penalty += _OUT_OF_REACH
        if self._options.layout_weight > 0.0:
            penalty += self._options.layout_weight * (self.difference(proposal) or 0.0)
        return penalty

    def needless_turn(self, candidate: Candidate) -> float:
        """What counts further against an answer whose relative was turned over.

        Not while searching: what is rugged may show the relation no other way.
        """
        if candidate.proposal is None or not self.is_level:
            return 0.0
        now = self._targets.now[1].rotation
        return _NEEDLESS_TURN_WEIGHT * turned_over(now, candidate.proposal.relative.rotation)

    @property
    def is_level(self) -> bool:
        """Whether nothing leans in the demonstration, as far as that is known."""
        return self._wanted is not None and not leans(self._wanted)

    def difference(self, proposal: Proposal | None) -> float | None:
        """How unlike the demonstration's arrangement its own is; None where that is not known."""
        if proposal is None or self._wanted is None:
            return None
        return arrangement_difference(self._arranged(proposal), self._wanted)

    def is_alike(self, candidate: Candidate) -> bool:
        """Whether its arrangement is the demonstration's, as far as that is known."""
        if candidate.proposal is None or self._wanted is None:
            return True
        return is_alike(self._arranged(candidate.proposal), self._wanted)

    def _arranged(self, proposal: Proposal) -> Arrangement:
        if proposal not in self._arrangements:
            self._arrangements[proposal] = self._arrangement_of(proposal)
        return self._arrangements[proposal]

    def _arrangement_of(self, proposal: Proposal) -> Arrangement:
        base, relative = (
            replace(placed, body=solid.body)
            for placed, solid in zip(
                (proposal.base, proposal.relative), self._targets.tabletop.solids, strict=True
            )
        )
        return Arrangement.of(base, relative)
