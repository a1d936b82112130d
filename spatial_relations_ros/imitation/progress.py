"""What a request has found so far, whom it tells, and when it is to stop."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence

import numpy as np

from spatial_relations_ros.imitation.answers import AnswerMaker, distinct
from spatial_relations_ros.imitation.candidates import Candidate
from spatial_relations_ros.imitation.result import (
    ImitationAnswer,
    ImitationProgress,
    ImitationResult,
    ProgressCallback,
)
from spatial_relations_ros.imitation.stages import Stages

# Of the distance of similar relations.
_CLEAR = 0.6
# What is left of the time budget finishes the best answer.
_BUDGET_SHARE = 0.9


class Progress:
    """State of one request; at every moment since its first answer there is a best one.

    Attributes:
        stages: where its time goes.
        best: the best answer so far.
        stopped: whether the caller or the time budget ended it.
        num_steps: of the optimiser.
    """

    best: ImitationAnswer

    def __init__(
        self,
        maker: AnswerMaker,
        stages: Stages,
        on_progress: ProgressCallback | None,
        start_time: float,
    ) -> None:
        """Begins a request.

        Args:
            maker: ranks its answers.
            stages: where its time goes.
            on_progress: asked whether to go on.
            start_time: on the monotonic clock, seconds; the time budget counts from there.
        """
        self.stages = stages
        self.stopped = False
        self.num_steps = 0
        self._maker, self._on_progress, self._start_time = maker, on_progress, start_time
        self._answers: list[ImitationAnswer] = []
        self._history: list[float] = []
        self._cancelled = self._late = False

    def add(self, answers: Sequence[ImitationAnswer]) -> None:
        """Takes further answers; the distance of the very first one begins the curve."""
        self._answers += answers
        self.best = self._maker.rank(self._answers)[0]
        self._history = self._history or [self.best.distance]

    def note(self, found: Sequence[Candidate]) -> None:
        """The nearest placement so far, for the curve."""
        self._history.append(min([self._history[-1], *(c.distance for c in found)]))

    def note_distances(self, distances: Sequence[float], *, falling: bool = False) -> None:
        """Further distances for the curve.

        Args:
            distances: of steps.
            falling: whether only what is nearer than before counts.
        """
        for distance in distances:
            self._history.append(min(distance, self._history[-1]) if falling else distance)

    def keep_going(self) -> bool:
        """Reports progress; False, from then on, when the caller or the time budget says so."""
        if not self.stopped and self._on_progress is not None:
            best = self.best
            told = ImitationProgress(self.num_steps, best.distance, best.feasible, best)
            self._cancelled = not self._on_progress(told)
        budget = self._maker.options.time_budget_sec or math.inf
        self._late = self._late or time.monotonic() - self._start_time > _BUDGET_SHARE * budget
        self.stopped = self.stopped or self._cancelled or self._late
        return not self.stopped

    @property
    def is_clear(self) -> bool:
        """Whether the best answer is so near that there is no need to look on."""
        near = self.best.distance < _CLEAR * self._maker.objective.similar_distance
        return self.best.feasible and self.best.alike and near

    @property
    def is_success(self) -> bool:
        """Whether the best answer is feasible and similar to the demonstration."""
        return self._maker.is_success(self.best)

    def result(self) -> ImitationResult:
        """What is answered."""
        best, *others = distinct(self._maker.rank(self._answers), self._maker.objective.extent)
        # The nearest attempt is told where nothing succeeded; a further one is no alternative.
        answers = [best, *(answer for answer in others if self._maker.is_success(answer))]
        similar_distance = self._maker.objective.similar_distance
        return ImitationResult(
            success=self._maker.is_success(best),
            message=self._reason() + _message(best, self._history[0], similar_distance),
            answers=tuple(answers[: self._maker.options.num_answers]),
            distance_history=np.array(self._history, dtype=np.float32),
            initial_distance=self._history[0],
            duration_sec=time.monotonic() - self._start_time,
            num_steps=self.num_steps,
            cancelled=self._cancelled,
            stage_seconds=self.stages.seconds,
        )

    def _reason(self) -> str:
        """Why the search ended early; empty when it did not, or found what was asked for."""
        if self._cancelled:
            return 'cancelled; best answer so far: '
        if self._late and not self.is_success:
            budget = self._maker.options.time_budget_sec
            return f'the time budget of {budget:g} s was too short: '
        return ''


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
