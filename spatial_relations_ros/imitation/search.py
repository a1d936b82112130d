"""Looking for placements that resemble the demonstration: many proposals, then near the best."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from torch import Tensor

from spatial_relations_ros.core import Scene
from spatial_relations_ros.imitation.appraisal import Appraisal
from spatial_relations_ros.imitation.candidates import Candidate, PosePair
from spatial_relations_ros.imitation.feasibility import MAX_PENETRATION
from spatial_relations_ros.imitation.manipulation import obstacle_depths
from spatial_relations_ros.imitation.objective import Objective
from spatial_relations_ros.imitation.options import ImitationOptions
from spatial_relations_ros.imitation.orientations import resting_orientations, standing_bases
from spatial_relations_ros.imitation.pose_optimizer import PoseBatch, evaluate
from spatial_relations_ros.imitation.poses import pose_tensors, row_poses
from spatial_relations_ros.imitation.proposals import Proposal, Proposer
from spatial_relations_ros.imitation.reaching import Reaching
from spatial_relations_ros.imitation.rest import Rest
from spatial_relations_ros.imitation.stages import EMBEDDING, Stages
from spatial_relations_ros.imitation.tabletop import Tabletop
from spatial_relations_ros.imitation.targets import Targets
from spatial_relations_ros.placement.arrangement import Arrangement
from spatial_relations_ros.placement.settling import Manner
from spatial_relations_ros.placement.tipping import tipped

_CHUNK = 8
_WIDE_SHARE = 0.5
_NUM_PARENTS = 5
# When the search goes on: so many drawn, in so many ways, and so many of them compared.
_NUM_DRAWN, _MOST_CELLS, _NUM_RESTING = 32, 16, 16
_NUM_FOOTHOLDS = 32
_NOT_CARRIED = 0.4
_NEAR_START = 0.25
_NEAR_START_RAD = math.radians(20.0)


class PlacementSearch:
    """Proposes placements, first of all kinds, then more of those that come nearest.

    Only the objects that may move are moved. A base that moves stays above its present place, in
    any orientation in which it rests; a base that alone moves is brought to the relative.

    Attributes:
        rest: brings candidates to rest.
        appraisal: what they are worth beside their distance.
    """

    def __init__(
        self,
        test: Scene,
        objective: Objective,
        tabletop: Tabletop,
        movable: tuple[bool, bool],
        options: ImitationOptions,
        *,
        arrangement: Arrangement | None = None,
        stages: Stages | None = None,
        keep_going: Callable[[], bool] = lambda: True,
    ) -> None:
        """Lists what can be proposed; see :class:`Proposer`.

        Args:
            test: the objects where they stand.
            objective: what placements are compared by.
            tabletop: the same objects as solids.
            movable: whether base and relative may move.
            options: of the request.
            arrangement: of the demonstration, if that is known.
            stages: where the time of embedding is counted.
            keep_going: asked before each proposal; False ends the search.
        """
        self._stages, self._keep_going = stages or Stages(), keep_going
        self._objective, self._options, self._movable = objective, options, movable
        self._reaching = Reaching(test, objective.shapes, movable, options)
        self._targets = Targets(test, tabletop, movable)
        self.rest = Rest(self._targets, upright=options.keep_upright)
        self.appraisal = Appraisal(self._targets, self._reaching, options, arrangement)
        self._rng = np.random.default_rng(options.seed)
        base, relative = self._targets.now
        bases = [base]
        if movable[0]:
            bases = standing_bases(base, upright=options.keep_upright)
        orientations = [relative.rotation]
        if movable[1]:
            orientations = resting_orientations(relative.body, relative.rotation)
            orientations = orientations[:1] if options.keep_upright else orientations
        may_lean = movable[1] and not options.keep_upright
        heading = objective.heading
        self._proposer = Proposer(
            bases,
            relative.body,
            orientations,
            self._rng,
            may_lean=may_lean,
            on_table=options.keep_on_table,
            heading=None if heading is None else heading.double().numpy(),
            spacing=float(objective.layout.spacing[0]),
        )

    def run(self) -> Iterator[list[Candidate]]:
        """Candidates, a handful at a time; stop whenever there is no more time."""
        found: list[Candidate] = []
        cells = len(self._proposer.cells)
        if not cells:
            return
        wide = max(round(_WIDE_SHARE * self._options.num_proposals), cells)
        # Each kind once, in random order, before any comes twice.
        order = [idx for _ in range(-(-wide // cells)) for idx in self._rng.permutation(cells)]
        for start in range(0, wide, _CHUNK):
            picked = order[start : min(start + _CHUNK, wide)]
            drawn = self._while_wanted(self._proposer.draw(idx) for idx in picked)
            if found and len(drawn) < len(picked):
                return  # a stop: what is known already is the answer soonest
            found += (chunk := self._compared(drawn))
            yield chunk
        for _ in range(max(self._options.num_proposals - wide, 0) // _CHUNK):
            if not found:
                return
            found += (chunk := self.more(found))
            yield chunk

    def started(self, poses: PosePair) -> list[Candidate]:
        """Candidates at rest near given poses: one for each manner in which they can rest."""
        cells = self._proposer.cells
        candidates = []
        for manner in Manner:
            kinds = [idx for idx, cell in enumerate(cells) if cell.manner is manner]
            settled = self.rest.settled(Candidate(poses, np.inf, np.inf, manner), exact=False)
            if not kinds or settled is None or settled.proposal is None:
                continue
            if settled.poses[1].is_close(
                poses[1], metres=_NEAR_START * self._objective.extent, angle_rad=_NEAR_START_RAD
            ):
                proposal = replace(settled.proposal, cell=kinds[0])
                candidates.append(replace(settled, proposal=proposal))
        return self.measured([c for c in candidates if self._is_free(c.poses)])

    def more(self, found: Sequence[Candidate]) -> list[Candidate]:
        """Some more like the best of what was found."""
        return self._compared(self._near_the_best(found))

    def resting(self, found: Sequence[Candidate]) -> list[Candidate]:
        """Some that come to rest, in the ways of the nearest that were found.

        Many are drawn; only those are compared whose arrangement is most like the demonstration's.
        """
        best = sorted(found, key=lambda candidate: candidate.cost)
        cells = list(dict.fromkeys(c.proposal.cell for c in best if c.proposal is not None))
        cells = cells[:_MOST_CELLS]
        drawn = self._while_wanted(
            self._rested(self._proposer.draw(cell)) for cell in self._repeated(cells)
        )
        drawn += self._while_wanted(self._on_footholds())
        at_rest = [proposal for proposal in drawn if proposal is not None]
        at_rest.sort(key=lambda proposal: self.appraisal.difference(proposal) or 0.0)
        return self._compared(at_rest[:_NUM_RESTING])

    def _on_footholds(self) -> Iterator[Proposal]:
        # What is let down onto a foothold tips until it rests there.
        if self.appraisal.needs_foothold and not self._options.keep_upright:
            yield from self._proposer.on_footholds(_NUM_FOOTHOLDS)

    def _repeated(self, cells: Sequence[int]) -> list[int]:
        return [cells[idx % len(cells)] for idx in range(_NUM_DRAWN)] if cells else []

    def _rested(self, proposal: Proposal | None) -> Proposal | None:
        """What was let down tilted until it rests; None where it does not."""
        may_tip = not self._options.keep_upright
        if proposal is None or not (may_tip and proposal.manner is Manner.DROPPED):
            return proposal
        placed = tipped(proposal.relative, proposal.base)
        return None if placed is None else replace(proposal, relative=placed)

    def _near_the_best(self, found: Sequence[Candidate]) -> list[Proposal | None]:
        best = sorted(found, key=lambda candidate: candidate.cost)
        parents = [c.proposal for c in best[:_NUM_PARENTS] if c.proposal is not None]
        cells = list(dict.fromkeys(c.proposal.cell for c in best if c.proposal is not None))
        varied = (self._proposer.vary(parent) for parent in parents)
        cells = cells[: _CHUNK - len(parents)]
        others = (self._proposer.draw(cell) for cell in cells)
        drawn = self._while_wanted(itertools.chain(varied, others))
        # After a stop what is known already is the answer soonest.
        return drawn if len(drawn) == len(parents) + len(cells) else []

    def _while_wanted(self, drawn: Iterator[Proposal | None]) -> list[Proposal | None]:
        """What is drawn until a stop: a chunk may take longer than a caller waits after one."""
        return list(itertools.takewhile(lambda _: self._keep_going(), drawn))

    def doubt(self, candidate: Candidate) -> float:
        """How little a placement that may not stay is worth as an attempt, beside its distance."""
        rolls = self.rest.rolls(candidate)
        return self.appraisal.penalty(candidate) + (_NOT_CARRIED if rolls else 0.0)

    def measured(self, candidates: Sequence[Candidate]) -> list[Candidate]:
        """The same placements with their distances and costs."""
        if not candidates:
            return []
        batch = self._evaluate([candidate.poses for candidate in candidates])
        return [
            Candidate(
                c.poses,
                float(distance),
                float(cost) + self.appraisal.penalty(c),
                c.manner,
                c.proposal,
            )
            for c, distance, cost in zip(candidates, batch.distances, batch.costs, strict=True)
        ]

    def refined(self, batch: PoseBatch, starts: Sequence[Candidate]) -> list[Candidate]:
        """What became of starts in the optimiser, brought to rest in the starts' manners."""
        moved = [
            Candidate(
                row_poses(batch, row, self._objective.origin),
                float(batch.distances[row]),
                float(batch.costs[row]),
                start.manner,
                start.proposal,
            )
            for row, start in enumerate(starts)
        ]
        settled = [self.rest.settled(candidate, exact=False) for candidate in moved]
        return self.measured([candidate for candidate in settled if candidate is not None])

    def tensors(self, candidate: Candidate) -> tuple[Tensor, Tensor]:
        """Rotations (1, 2, 3, 3) and translations (1, 2, 3) from the objective's origin."""
        return pose_tensors([candidate.poses], self._objective.origin)

    def batch(self, candidates: Sequence[Candidate]) -> PoseBatch:
        """Candidates as the optimiser takes them."""
        return self._evaluate([candidate.poses for candidate in candidates])

    def _evaluate(self, pairs: Sequence[PosePair]) -> PoseBatch:
        rotations, translations = pose_tensors(pairs, self._objective.origin)
        with self._stages.timed(EMBEDDING):
            return evaluate(self._objective, rotations, translations, at_rest=True)

    def _compared(self, proposals: Sequence[Proposal | None]) -> list[Candidate]:
        in_reach = [
            self._reaching.turned(p, self._targets.poses) for p in proposals if p is not None
        ]
        placed = [(p, self._targets.poses(p)) for p in in_reach]
        usable = [
            Candidate(poses, np.inf, np.inf, proposal.manner, proposal)
            for proposal, poses in placed
            if poses is not None
        ]
        return self.measured([c for c in usable if self._is_free(c.poses)])

    def _is_free(self, poses: PosePair) -> bool:
        """Whether what moves is clear of the obstacles."""
        obstacles = self._options.obstacles
        depths = [
            float(obstacle_depths(self._objective.shapes[role], [poses[role]], obstacles)[0])
            for role in (0, 1)
            if self._movable[role]
        ]
        return max(depths) <= MAX_PENETRATION
