"""Imitation of a demonstrated relation with two other objects."""

from __future__ import annotations

import math
import time

import numpy as np
import torch
from torch import Tensor

from spatial_relations_ros.core import Scene
from spatial_relations_ros.imitation.answers import AnswerMaker, distinct
from spatial_relations_ros.imitation.arrangement import (
    arrangement_difference,
    demonstrated_arrangement,
    is_alike,
)
from spatial_relations_ros.imitation.objective_setup import make_objective
from spatial_relations_ros.imitation.options import ROLES, ImitationOptions
from spatial_relations_ros.imitation.pose_optimizer import PoseBatch, evaluate, refine
from spatial_relations_ros.imitation.poses import pose_tensors
from spatial_relations_ros.imitation.result import (
    ImitationAnswer,
    ImitationProgress,
    ImitationResult,
    ProgressCallback,
)
from spatial_relations_ros.imitation.search import Candidate, PlacementSearch
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

_MAX_CHECKS = 16
_CHECKS_AFTER_STOP = 3
# Of the distance of similar relations: nothing beyond is worth a check.
_HOPELESS = 1.2
_CLEAR = 0.6
# What barely stays is one of several, the rest may be steadier.
_UNSTEADY_COUNT = 0.4
_OTHERWISE_COUNT = 0.2
_MAX_MORE = 3
_SPARE_ANSWERS = 1
_SAME_SHIFT = 0.02
# Of half of the angle, as quaternions are compared.
_SAME_TURN_COSINE = math.cos(math.radians(2.0))
# What is left of the time budget finishes the best answer.
_BUDGET_SHARE = 0.9


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
        self.start_time = time.monotonic()
        self.options, self.on_progress = options, on_progress
        self.reference, self.test = reference, test
        self.stages = Stages()
        with self.stages.timed(PREPARATION):
            self.objective = make_objective(metric, reference, test, options)
        self.movable = (ROLES[0] in options.movable, ROLES[1] in options.movable)
        self.maker = AnswerMaker(test, self.objective, options, self.movable)
        self.answers: list[ImitationAnswer] = []
        self.best: ImitationAnswer
        self.cancelled = self.stopped = self.late = False
        self.num_steps = 0
        self.history: list[float] = []

    def run(self) -> ImitationResult:
        """Proposals, refinement, checks; at every moment there is a best answer."""
        base, relative = (item.world_from_object for item in self.test.objects)
        poses = pose_tensors([(base, relative)], self.objective.origin)
        with self.stages.timed(CHECKS):
            self._add([self._as_it_stands(*poses)])
        self.history.append(self.best.distance)
        if self.options.physics_weight == 0.0:
            self._descend_freely(evaluate(self.objective, *poses))
        elif self._keep_going(0):
            self._place()
        best, *others = distinct(self.maker.rank(self.answers), self.objective.extent)
        # The nearest attempt is told where nothing succeeded; a further one is no alternative.
        answers = [best, *(answer for answer in others if self._is_success(answer))]
        return self._result(tuple(answers[: self.options.num_answers]), self.history)

    def _as_it_stands(self, rotations: Tensor, translations: Tensor) -> ImitationAnswer:
        """The test scene as an answer, with what its arrangement adds to the distance."""
        (answer,) = self.maker.answers(rotations, translations)
        weight = self.options.layout_weight
        if self.options.physics_weight == 0.0 or weight == 0.0:
            return answer
        now, wanted = (demonstrated_arrangement(scene) for scene in (self.test, self.reference))
        if now is None or wanted is None:
            return answer
        extra = weight * arrangement_difference(now, wanted)
        return self.maker.handicapped(
            answer, steady=True, alike=is_alike(now, wanted), extra=extra
        )

    def _place(self) -> None:
        """Looks for placements at rest, refines the nearest, checks what comes out."""
        with self.stages.timed(PREPARATION):
            search = self._search()
        tried: set[Candidate] = set()
        found = self._near_start(search, tried)
        if found and self._is_clear(self.best):
            return
        if not (found and self.stopped):
            with self.stages.timed(PROPOSALS):
                found += self._proposed(search)
            self._refine_nearest(search, found)
            self._check(search, found, tried)
        for _ in range(_MAX_MORE if self.options.propose else 0):
            is_sure = self.best.steady or not search.needs_foothold
            if (is_sure and self._is_clear(self.best)) or not self._keep_going(self.num_steps):
                break
            # Nothing near the demonstration stays: look on around what was not tried yet.
            rested: list[Candidate] = []
            with self.stages.timed(PROPOSALS):
                untried = [c for c in found if c not in tried] or found
                found += search.more(untried)
                if self._keep_going(self.num_steps):
                    rested = search.resting(untried)
            found += rested
            self._note(found)
            # What came to rest and is arranged alike comes before what is nearer and may fall.
            alike = [c for c in rested if search.is_alike(c)]
            self._check(search, alike or found, tried)
        is_success = self._is_success(self.best) and self.best.alike
        if not is_success and self._keep_going(self.num_steps):
            # What stays and is arranged alike is a better attempt than what is near and falls.
            alike = [c for c in found if search.is_alike(c)]
            self._check(search, alike, tried, farthest=math.inf)

    def _near_start(self, search: PlacementSearch, tried: set[Candidate]) -> list[Candidate]:
        """What is found near the poses to begin with; it is checked. Empty without such poses."""
        if self.options.start is None:
            return []
        with self.stages.timed(PROPOSALS):
            found = search.started(self.options.start)
            if found and self._keep_going(0):
                found += search.more(found)
        if found:
            self._note(found)
            self._check(search, found, tried)
        if found and not self._is_clear(self.best):
            self._refine_nearest(search, found)
            self._check(search, found, tried)
        return found

    def _refine_nearest(self, search: PlacementSearch, found: list[Candidate]) -> None:
        """Descends from the nearest candidates; what comes out is added to them."""
        if self.stopped or not self.options.max_steps:
            return
        with self.stages.timed(REFINEMENT):
            starts = _unlike(found, self.objective.extent)[: self.options.num_starts]
            refined = self._refined(search.batch(starts))
            found += search.refined(refined, starts)
        self._note(found)

    def _refined(self, starts: PoseBatch) -> PoseBatch:
        if not self.options.soft_refinement:
            return self._refine(starts)[0]
        return refine_softly(
            self.objective,
            self.reference,
            starts,
            self.movable,
            steps=self.options.max_steps,
            learning_rate=self.options.learning_rate,
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
            keep_going=lambda: self._keep_going(self.num_steps),
        )

    def _proposed(self, search: PlacementSearch) -> list[Candidate]:
        """What was proposed and compared, or the scene as it stands; a stop ends it early."""
        found: list[Candidate] = []
        if self.options.propose:
            for chunk in search.run():
                found += chunk
                self._note(found)
                if not self._keep_going(0):
                    break
        if not found:
            poses = self.test.base.world_from_object, self.test.relative.world_from_object
            found = search.measured([Candidate(poses, math.inf, math.inf)])
        return found

    def _check(
        self,
        search: PlacementSearch,
        found: list[Candidate],
        tried: set[Candidate],
        *,
        farthest: float = _HOPELESS,
    ) -> None:
        """Makes answers of the nearest candidates that stay where they are put.

        Those that were looked at are added to the tried ones, which are not looked at again.
        """
        # After a stop the best is finished, unless there is a good one already.
        if self.stopped and self._is_success(self.best):
            return
        with self.stages.timed(CHECKS):
            self._make_answers(search, found, tried, farthest)

    def _make_answers(
        self,
        search: PlacementSearch,
        found: list[Candidate],
        tried: set[Candidate],
        farthest: float,
    ) -> None:
        wanted = self.options.num_answers + _SPARE_ANSWERS
        nearest: Candidate | None = None
        num_feasible, answered = 0.0, set[Candidate]()
        untried = [candidate for candidate in found if candidate not in tried]
        # After a stop only the best one that can rest is finished, so that the stop is prompt.
        at_most = _CHECKS_AFTER_STOP if self.stopped else _MAX_CHECKS
        for candidate in _unlike(untried, self.objective.extent)[:at_most]:
            if candidate.distance > farthest * self.objective.similar_distance and nearest:
                break
            exact = search.settled(candidate)
            tried.add(candidate)
            if exact is None:
                continue
            if nearest is None or search.doubt(exact) < search.doubt(nearest):
                nearest = exact
            if search.stays(exact):
                (answer,) = self.maker.answers(*search.tensors(exact))
                # What else there is to choose from decides whether that matters.
                steady = self.stopped or search.is_steady(exact)
                alike, extra = search.is_alike(exact), search.manner_penalty(exact)
                self._add(
                    [self.maker.handicapped(answer, steady=steady, alike=alike, extra=extra)]
                )
                answered.add(exact)
                num_feasible += answer.feasible * _worth(steady=steady, alike=alike)
            if num_feasible >= wanted or not self._keep_going(self.num_steps):
                break
        if nearest is not None and nearest not in answered and not self._is_success(self.best):
            (answer,) = self.maker.answers(*search.tensors(nearest))
            alike, doubt = search.is_alike(nearest), search.doubt(nearest)
            self._add([self.maker.handicapped(answer, steady=True, alike=alike, extra=doubt)])

    def _is_clear(self, answer: ImitationAnswer) -> bool:
        """Whether an answer is so near that there is no need to look on."""
        near = answer.distance < _CLEAR * self.objective.similar_distance
        return answer.feasible and answer.alike and near

    def _is_success(self, answer: ImitationAnswer) -> bool:
        return answer.feasible and answer.distance < self.objective.similar_distance

    def _descend_freely(self, current: PoseBatch) -> None:
        """Gradient descent on the metric alone, from where the objects stand (the paper's)."""
        starts = current.select(torch.zeros(1, dtype=torch.int64))
        refined, distances = self._refine(starts)
        self.history += distances[1:, 0].tolist()
        self._add(self.maker.answers(refined.rotations, refined.translations))

    def _refine(self, starts: PoseBatch) -> tuple[PoseBatch, torch.Tensor]:
        return refine(
            self.objective,
            starts,
            self.movable,
            steps=self.options.max_steps,
            learning_rate=self.options.learning_rate,
            on_step=self._on_step,
        )

    def _on_step(self, step: int, best: PoseBatch) -> bool:
        self.num_steps = step
        if self.options.physics_weight > 0.0:
            self.history.append(min(float(best.distances.min()), self.history[-1]))
        return self._keep_going(step)

    def _note(self, found: list[Candidate]) -> None:
        """The nearest placement so far, for the curve."""
        self.history.append(min([self.history[-1], *(c.distance for c in found)]))

    def _add(self, answers: list[ImitationAnswer]) -> None:
        self.answers += answers
        self.best = self.maker.rank(self.answers)[0]

    def _keep_going(self, step: int) -> bool:
        """Reports progress; False, from then on, when the caller or the time budget says so."""
        if not self.stopped and self.on_progress is not None:
            best = self.best
            progress = ImitationProgress(step, best.distance, best.feasible, best)
            self.cancelled = not self.on_progress(progress)
        budget = self.options.time_budget_sec or math.inf
        self.late = self.late or time.monotonic() - self.start_time > _BUDGET_SHARE * budget
        self.stopped = self.stopped or self.cancelled or self.late
        return not self.stopped

    def _result(
        self,
        answers: tuple[ImitationAnswer, ...],
        history: list[float],
    ) -> ImitationResult:
        best = answers[0]
        similar_distance = self.objective.similar_distance
        return ImitationResult(
            success=self._is_success(best),
            message=self._reason() + _message(best, history[0], similar_distance),
            answers=answers,
            distance_history=np.array(history, dtype=np.float32),
            initial_distance=history[0],
            duration_sec=time.monotonic() - self.start_time,
            num_steps=self.num_steps,
            cancelled=self.cancelled,
            stage_seconds=self.stages.seconds,
        )

    def _reason(self) -> str:
        """Why the search ended early; empty when it did not, or found what was asked for."""
        if self.cancelled:
            return 'cancelled; best answer so far: '
        if self.late and not self._is_success(self.best):
            return f'the time budget of {self.options.time_budget_sec:g} s was too short: '
        return ''


def _worth(*, steady: bool, alike: bool) -> float:
    """What a feasible answer counts towards those that are wanted."""
    return (1.0 if steady else _UNSTEADY_COUNT) * (1.0 if alike else _OTHERWISE_COUNT)


def _unlike(candidates: list[Candidate], extent: float) -> list[Candidate]:
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


def _message(best: ImitationAnswer, initial_distance: float, similar_distance: float) -> str:
    fell = f'distance {initial_distance:.2f} before, {best.distance:.2f} after'
    if best.distance >= similar_distance:
        return (
            f'no placement was found that is similar to the demonstration: {fell}; '
            f'similar relations lie below {similar_distance:.2f}'
        )
    if not best.feasible:
        return f'no feasible placement was found; the nearest: {"; ".join(best.violations)}'
    return fell
