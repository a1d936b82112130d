"""Imitation of a demonstrated relation with two other objects."""

from __future__ import annotations

import math
import time

import torch
from torch import Tensor

from spatial_relations_ros.core import Scene
from spatial_relations_ros.imitation.answers import AnswerMaker
from spatial_relations_ros.imitation.arrangement import (
    arrangement_difference,
    demonstrated_arrangement,
    is_alike,
)
from spatial_relations_ros.imitation.candidates import Candidate, unlike
from spatial_relations_ros.imitation.checking import Checker
from spatial_relations_ros.imitation.lean import stands_as_before
from spatial_relations_ros.imitation.objective_setup import make_objective
from spatial_relations_ros.imitation.options import ROLES, ImitationOptions
from spatial_relations_ros.imitation.pose_optimizer import PoseBatch, drawn_rates, evaluate, refine
from spatial_relations_ros.imitation.poses import pose_tensors
from spatial_relations_ros.imitation.progress import Progress
from spatial_relations_ros.imitation.result import (
    ImitationAnswer,
    ImitationResult,
    ProgressCallback,
)
from spatial_relations_ros.imitation.search import PlacementSearch
from spatial_relations_ros.imitation.soft_refinement import refine_softly
from spatial_relations_ros.imitation.stages import (
    CHECKS,
    PREPARATION,
    PROPOSALS,
    REFINEMENT,
    Stages,
)
from spatial_relations_ros.imitation.tabletop import Tabletop
from spatial_relations_ros.learning import RelationMetric

_MAX_MORE = 3


def imitate(
    metric: RelationMetric,
    reference: Scene,
    test: Scene,
    options: ImitationOptions | None = None,
    *,
    on_progress: ProgressCallback | None = None,
) -> ImitationResult:
    """Finds poses of the test objects that imitate the relation of the reference objects.

    The i-th test object plays the part of the i-th reference object. Placements are proposed
    from the shapes and compared under the metric; the nearest are refined by gradient descent
    through the metric (Jund et al. 2018, section III-C), brought to rest again, and checked.

    Args:
        metric: the learned metric; not used by another thread meanwhile.
        reference: the demonstration.
        test: the objects to place, where they stand now.
        options: settings; None for the defaults.
        on_progress: called after each proposal, check and step; returning False cancels.

    Raises:
        ImitationError: when the test objects are so large or far apart that the numbers are not
            usable.
    """
    return _Imitation(metric, reference, test, options or ImitationOptions(), on_progress).run()


class _Imitation:
    """State of one request."""

    def __init__(
        self,
        metric: RelationMetric,
        reference: Scene,
        test: Scene,
        options: ImitationOptions,
        on_progress: ProgressCallback | None,
    ) -> None:
        start_time = time.monotonic()
        self.options, self.reference, self.test = options, reference, test
        self.stages = Stages()
        with self.stages.timed(PREPARATION):
            self.objective = make_objective(metric, reference, test, options)
        self.movable = (ROLES[0] in options.movable, ROLES[1] in options.movable)
        self.maker = AnswerMaker(test, self.objective, options, self.movable)
        self.progress = Progress(self.maker, self.stages, on_progress, start_time)

    def run(self) -> ImitationResult:
        """Proposals, refinement, checks; at every moment there is a best answer."""
        base, relative = (item.world_from_object for item in self.test.objects)
        poses = pose_tensors([(base, relative)], self.objective.origin)
        with self.stages.timed(CHECKS):
            self.progress.add([self._as_it_stands(*poses)])
        if self.options.physics_weight == 0.0:
            self._descend_freely(evaluate(self.objective, *poses))
        elif self.progress.keep_going():
            self._place()
        return self.progress.result()

    def _as_it_stands(self, rotations: Tensor, translations: Tensor) -> ImitationAnswer:
        """The test scene as an answer, with what its arrangement adds to the distance."""
        (answer,) = self.maker.answers(rotations, translations)
        weight = self.options.layout_weight
        if self.options.physics_weight == 0.0 or weight == 0.0:
            return answer
        now, wanted = (demonstrated_arrangement(scene) for scene in (self.test, self.reference))
        if now is None or wanted is None:
            return answer
        difference = arrangement_difference(now, wanted)
        return self.maker.handicapped(
            answer,
            alike=is_alike(now, wanted),
            difference=difference,
            extra=weight * difference,
        )

    def _place(self) -> None:
        """Looks for placements at rest, refines the nearest, checks what comes out."""
        progress = self.progress
        with self.stages.timed(PREPARATION):
            search = self._search()
        checker = Checker(search, self.maker, progress)
        found = self._near_start(search, checker)
        if found and progress.is_clear:
            return
        if not (found and progress.stopped):
            with self.stages.timed(PROPOSALS):
                found += self._proposed(search)
            self._refine_nearest(search, found)
            checker.check(found)
        for _ in range(_MAX_MORE if self.options.propose else 0):
            is_sure = progress.best.steady or not search.appraisal.needs_foothold
            if (is_sure and progress.is_clear) or not progress.keep_going():
                break
            self._look_on(search, found, checker)
        self._leave_standing(search, found, checker)
        is_success = progress.is_success and progress.best.alike
        if not is_success and progress.keep_going():
            # What stays and is arranged alike is a better attempt than what is near and falls.
            alike = [c for c in found if search.appraisal.is_alike(c)]
            checker.check(alike, farthest=math.inf)

    def _look_on(self, search: PlacementSearch, found: list[Candidate], checker: Checker) -> None:
        """Nothing near the demonstration stays: looks around what was not tried yet."""
        rested: list[Candidate] = []
        with self.stages.timed(PROPOSALS):
            untried = [c for c in found if c not in checker.tried] or found
            found += search.more(untried)
            if self.progress.keep_going():
                rested = search.resting(untried)
        found += rested
        self.progress.note(found)
        # What came to rest and is arranged alike comes before what is nearer and may fall.
        checker.check([c for c in rested if search.appraisal.is_alike(c)] or found)

    def _leave_standing(
        self, search: PlacementSearch, found: list[Candidate], checker: Checker
    ) -> None:
        """Looks for answers that leave the relative as it stands where the best one does not."""
        relative = self.progress.best.placements[1]
        turn = relative.current.rotation, relative.target.rotation
        if not (self.progress.is_success and search.appraisal.is_level) or stands_as_before(*turn):
            return

        def fits(candidate: Candidate) -> bool:
            stands = stands_as_before(turn[0], candidate.poses[1].rotation)
            return stands and search.appraisal.is_alike(candidate)

        standing = list(filter(fits, found))
        if standing and self.progress.keep_going():
            with self.stages.timed(PROPOSALS):
                standing += filter(fits, search.more(standing))
            self.progress.note(standing)
            checker.check(standing, farthest=1.0)

    def _near_start(self, search: PlacementSearch, checker: Checker) -> list[Candidate]:
        """What is found near the poses to begin with; it is checked. Empty without such poses."""
        if self.options.start is None:
            return []
        with self.stages.timed(PROPOSALS):
            found = search.started(self.options.start)
            if found and self.progress.keep_going():
                found += search.more(found)
        if found:
            self.progress.note(found)
            checker.check(found)
        if found and not self.progress.is_clear:
            self._refine_nearest(search, found)
            checker.check(found)
        return found

    def _refine_nearest(self, search: PlacementSearch, found: list[Candidate]) -> None:
        """Descends from the nearest candidates; what comes out is added to them."""
        if self.progress.stopped or not self.options.max_steps:
            return
        with self.stages.timed(REFINEMENT):
            starts = unlike(found, self.objective.extent)[: self.options.num_starts]
            refined = self._refined(search.batch(starts))
            found += search.refined(refined, starts)
        self.progress.note(found)

    def _refined(self, starts: PoseBatch) -> PoseBatch:
        if not self.options.soft_refinement:
            return self._refine(starts)[0]
        return refine_softly(
            self.objective,
            self.reference,
            starts,
            self.movable,
            steps=self.options.max_steps,
            learning_rates=self._learning_rates(starts),
            on_step=self._on_step,
        )

    def _search(self) -> PlacementSearch:
        tabletop = Tabletop.of(
            self.objective.shapes,
            self.test.base.world_from_object,
            self.objective.table_height,
        )
        return PlacementSearch(
            self.test,
            self.objective,
            tabletop,
            self.movable,
            self.options,
            arrangement=demonstrated_arrangement(self.reference),
            stages=self.stages,
            keep_going=self.progress.keep_going,
        )

    def _proposed(self, search: PlacementSearch) -> list[Candidate]:
        """What was proposed and compared, or the scene as it stands; a stop ends it early."""
        found: list[Candidate] = []
        if self.options.propose:
            for chunk in search.run():
                found += chunk
                self.progress.note(found)
                if not self.progress.keep_going():
                    break
        if not found:
            poses = self.test.base.world_from_object, self.test.relative.world_from_object
            found = search.measured([Candidate(poses, math.inf, math.inf)])
        return found

    def _descend_freely(self, current: PoseBatch) -> None:
        """Gradient descent on the metric alone, from where the objects stand (the paper's)."""
        starts = current.select(torch.zeros(1, dtype=torch.int64))
        refined, distances = self._refine(starts)
        self.progress.note_distances(distances[1:, 0].tolist())
        self.progress.add(self.maker.answers(refined.rotations, refined.translations))

    def _refine(self, starts: PoseBatch) -> tuple[PoseBatch, Tensor]:
        return refine(
            self.objective,
            starts,
            self.movable,
            steps=self.options.max_steps,
            learning_rates=self._learning_rates(starts),
            on_step=self._on_step,
        )

    def _learning_rates(self, starts: PoseBatch) -> Tensor:
        return drawn_rates(
            len(starts.costs),
            self.options.learning_rate,
            spread=self.options.learning_rate_spread,
            seed=self.options.seed,
        )

    def _on_step(self, step: int, best: PoseBatch) -> bool:
        self.progress.num_steps = step
        if self.options.physics_weight > 0.0:
            self.progress.note_distances([float(best.distances.min())], falling=True)
        return self.progress.keep_going()
