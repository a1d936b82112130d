"""Looking for placements that resemble the demonstration: many proposals, then near the best."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from torch import Tensor

from spatial_relations_ros.core import Pose, Scene
from spatial_relations_ros.core.rotations import tilt_angle_rad
from spatial_relations_ros.imitation.arrangement import (
    arrangement_difference,
    is_alike,
    rests_on_other,
)
from spatial_relations_ros.imitation.feasibility import MAX_PENETRATION
from spatial_relations_ros.imitation.lean import turned_over
from spatial_relations_ros.imitation.manipulation import obstacle_depths
from spatial_relations_ros.imitation.objective import Objective
from spatial_relations_ros.imitation.options import ImitationOptions
from spatial_relations_ros.imitation.orientations import resting_orientations
from spatial_relations_ros.imitation.pose_optimizer import PoseBatch, evaluate
from spatial_relations_ros.imitation.poses import pose_tensors, row_poses
from spatial_relations_ros.imitation.proposals import Proposal, Proposer
from spatial_relations_ros.imitation.reaching import Reaching
from spatial_relations_ros.imitation.stages import EMBEDDING, Stages
from spatial_relations_ros.imitation.statics import rest_together, rests
from spatial_relations_ros.imitation.tabletop import Tabletop
from spatial_relations_ros.placement.arrangement import Arrangement
from spatial_relations_ros.placement.body import Placed
from spatial_relations_ros.placement.resting import UP, about_z
from spatial_relations_ros.placement.settling import Manner, settle
from spatial_relations_ros.placement.stability import TABLE_TILT_RAD
from spatial_relations_ros.placement.tipping import MAX_ROLL_RAD, Ground, tipped

_CHUNK = 8
_WIDE_SHARE = 0.5
_NUM_PARENTS = 5
# When the search goes on: so many drawn, in so many ways, and so many of them compared.
_NUM_DRAWN, _MOST_CELLS, _NUM_RESTING = 32, 16, 16
_NUM_FOOTHOLDS = 32
# What does not have to be turned over is left as it stands.
_TURN_WEIGHT = 0.08
# What no arm reaches comes after all that one does.
_OUT_OF_REACH = 1.0
_STEADY_TILT_RAD = math.radians(8.0)
_HAIR = 3e-4
_NOT_CARRIED = 0.4
_NEAR_START = 0.25
_NEAR_START_RAD = math.radians(20.0)
_SAME_HEIGHT = 0.004
_SAME_TILT_RAD = 0.05

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


class PlacementSearch:
    """Proposes placements, first of all kinds, then more of those that come nearest.

    Only the objects that may move are moved. A base that moves stays above its present place, in
    any orientation in which it rests; a base that alone moves is brought to the relative.
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
        self._arrangement = arrangement
        # Measured once: search, ranking and checks ask for them again.
        self._arrangements: dict[Proposal, Arrangement] = {}
        self._grounds: dict[Proposal, Ground | None] = {}
        self._stages, self._keep_going = stages or Stages(), keep_going
        self._reaching = Reaching(test, objective.shapes, movable, options)
        self._test, self._objective, self._tabletop = test, objective, tabletop
        self._movable, self._options = movable, options
        self._rng = np.random.default_rng(options.seed)
        base, relative = (
            tabletop.placed(role, item.world_from_object) for role, item in enumerate(test.objects)
        )
        self._now = (base, relative)
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
            settled = self.settled(Candidate(poses, np.inf, np.inf, manner), exact=False)
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
        if self._arrangement is not None:
            wanted = self._arrangement
            at_rest.sort(key=lambda p: arrangement_difference(self._arranged(p), wanted))
        return self._compared(at_rest[:_NUM_RESTING])

    @property
    def needs_foothold(self) -> bool:
        """Whether the relative is to be carried by the base alone, as far as that is known."""
        return self._arrangement is None or rests_on_other(self._arrangement)

    def _on_footholds(self) -> Iterator[Proposal]:
        if self.needs_foothold:
            yield from self._proposer.on_footholds(_NUM_FOOTHOLDS)

    def _repeated(self, cells: Sequence[int]) -> list[int]:
        return [cells[idx % len(cells)] for idx in range(_NUM_DRAWN)] if cells else []

    def _rested(self, proposal: Proposal | None) -> Proposal | None:
        """What was let down tilted until it rests; None where it does not."""
        if proposal is None or proposal.manner is not Manner.DROPPED:
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

    def settled(self, candidate: Candidate, *, exact: bool = True) -> Candidate | None:
        """The candidate brought to rest in its manner; its distance is not measured again.

        Args:
            candidate: nearly at rest.
            exact: with all points of contact rather than with a quarter of them.

        Returns:
            None when it cannot rest in that manner.
        """
        base, relative = (
            self._tabletop.placed(role, pose) for role, pose in enumerate(candidate.poses)
        )
        if self._movable[0]:
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
        if exact and manner is Manner.DROPPED:
            placed = tipped(relative, base) or tipped(placed, base) or placed
        cell = candidate.proposal.cell if candidate.proposal else 0
        proposal = Proposal(base, placed, manner, cell)
        poses = self._poses(proposal)
        if poses is None:
            return None
        return Candidate(poses, candidate.distance, candidate.cost, manner, proposal)

    def stays(self, candidate: Candidate, *, tilt_rad: float = TABLE_TILT_RAD) -> bool:
        """Whether friction holds a placed candidate where it is, on a table tilted so far."""
        if candidate.proposal is None:
            return False
        base, relative = candidate.proposal.base, candidate.proposal.relative
        if all(self._movable):
            return rest_together(base, relative, tilt_rad=tilt_rad)
        return rests(relative, base, tilt_rad=tilt_rad) and (
            not self._movable[0] or rests(base, relative, tilt_rad=tilt_rad)
        )

    def is_steady(self, candidate: Candidate) -> bool:
        """Whether it stays on a table that is tilted more, and does not roll there."""
        if not self.stays(candidate, tilt_rad=_STEADY_TILT_RAD):
            return False
        ground = self._ground(candidate)
        return ground is None or ground.roll_rad(TABLE_TILT_RAD) <= MAX_ROLL_RAD

    def doubt(self, candidate: Candidate) -> float:
        """How little a placement that may not stay is worth as an attempt, beside its distance."""
        ground = self._ground(candidate)
        is_carried = ground is None or ground.roll_rad(0.0) <= MAX_ROLL_RAD
        return self.manner_penalty(candidate) + (0.0 if is_carried else _NOT_CARRIED)

    def _ground(self, candidate: Candidate) -> Ground | None:
        """What is below something that was let down; None for what rests in other manners."""
        if candidate.proposal is None or candidate.manner is not Manner.DROPPED:
            return None
        proposal = candidate.proposal
        if proposal not in self._grounds:
            raised = proposal.relative.moved(_HAIR * UP)
            self._grounds[proposal] = Ground.below(raised, proposal.base)
        return self._grounds[proposal]

    def measured(self, candidates: Sequence[Candidate]) -> list[Candidate]:
        """The same placements with their distances and costs."""
        if not candidates:
            return []
        batch = self._evaluate([candidate.poses for candidate in candidates])
        return [
            Candidate(
                c.poses,
                float(distance),
                float(cost) + self.manner_penalty(c),
                c.manner,
                c.proposal,
            )
            for c, distance, cost in zip(candidates, batch.distances, batch.costs, strict=True)
        ]

    def manner_penalty(self, candidate: Candidate) -> float:
        """For another arrangement than the demonstration's, turning things over, and reach."""
        if candidate.proposal is None:
            return 0.0
        now, proposal = self._now, candidate.proposal
        penalty = _TURN_WEIGHT * (
            turned_over(now[0], proposal.base) + turned_over(now[1], proposal.relative)
        )
        if self._options.arm is not None and not self._reaching.reaches(candidate.poses):
            penalty += _OUT_OF_REACH
        if self._arrangement is not None and self._options.layout_weight > 0.0:
            difference = arrangement_difference(self._arranged(proposal), self._arrangement)
            penalty += self._options.layout_weight * difference
        return penalty

    def is_alike(self, candidate: Candidate) -> bool:
        """Whether its arrangement is the demonstration's, as far as that is known."""
        if candidate.proposal is None or self._arrangement is None:
            return True
        return is_alike(self._arranged(candidate.proposal), self._arrangement)

    def _arranged(self, proposal: Proposal) -> Arrangement:
        if proposal not in self._arrangements:
            self._arrangements[proposal] = self._arrangement_of(proposal)
        return self._arrangements[proposal]

    def _arrangement_of(self, proposal: Proposal) -> Arrangement:
        base, relative = (
            replace(placed, body=solid.body)
            for placed, solid in zip(
                (proposal.base, proposal.relative), self._tabletop.solids, strict=True
            )
        )
        return Arrangement.of(base, relative)

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
        settled = [self.settled(candidate, exact=False) for candidate in moved]
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
        in_reach = [self._reaching.turned(p, self._poses) for p in proposals if p is not None]
        placed = [(p, self._poses(p)) for p in in_reach]
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

    def _poses(self, proposal: Proposal) -> PosePair | None:
        """World poses; None when a relative that must not move would have to."""
        base, relative = proposal.base, proposal.relative
        if not self._movable[1]:
            now = self._now[1]
            turn = now.rotation @ relative.rotation.T
            height = float(now.translation[2] - relative.translation[2])
            if tilt_angle_rad(turn) > _SAME_TILT_RAD or abs(height) > _SAME_HEIGHT:
                return None
            yaw = about_z(float(np.arctan2(turn[1, 0], turn[0, 0])))
            shift = now.translation - yaw @ relative.translation
            moved = Placed(base.body, yaw @ base.rotation, yaw @ base.translation + shift)
            return self._tabletop.pose(0, moved.on_table()), self._test.relative.world_from_object
        base_pose = self._test.base.world_from_object
        if self._movable[0]:
            base_pose = self._tabletop.pose(0, base)
        return base_pose, self._tabletop.pose(1, relative)


def standing_bases(base: Placed, *, upright: bool) -> list[Placed]:
    """The base on the table at its place, in the ways in which it rests."""
    orientations = resting_orientations(base.body, base.rotation)
    orientations = orientations[:1] if upright else orientations
    level = base.translation * [1.0, 1.0, 0.0]
    return [Placed(base.body, rotation, level).on_table() for rotation in orientations]
