"""Answers made of the nearest candidates that stay where they are put."""

from __future__ import annotations

from collections.abc import Sequence

from spatial_relations_ros.imitation.answers import AnswerMaker
from spatial_relations_ros.imitation.candidates import Candidate, unlike
from spatial_relations_ros.imitation.progress import Progress
from spatial_relations_ros.imitation.result import ImitationAnswer
from spatial_relations_ros.imitation.search import PlacementSearch
from spatial_relations_ros.imitation.stages import CHECKS

_MAX_CHECKS = 16
_CHECKS_AFTER_STOP = 3
# Of the distance of similar relations: nothing beyond is worth a check.
_HOPELESS = 1.2
# What barely stays is one of several, the rest may be steadier.
_UNSTEADY_COUNT = 0.4
_OTHERWISE_COUNT = 0.2
_SPARE_ANSWERS = 1


class Checker:
    """Checks candidates of one request, each at most once.

    Attributes:
        tried: those that were looked at.
    """

    def __init__(self, search: PlacementSearch, maker: AnswerMaker, progress: Progress) -> None:
        """Begins with none tried.

        Args:
            search: brings candidates to rest and says what they are worth.
            maker: makes answers of them.
            progress: takes the answers.
        """
        self.tried: set[Candidate] = set()
        self._search, self._maker, self._progress = search, maker, progress
        self._rest, self._appraisal = search.rest, search.appraisal

    def check(self, found: Sequence[Candidate], *, farthest: float = _HOPELESS) -> None:
        """Makes answers of the nearest candidates that stay where they are put.

        Args:
            found: candidates; those that were tried are left out.
            farthest: in shares of the distance of similar relations; beyond it none is looked at
                but the first that can rest.
        """
        # After a stop the best is finished, unless there is a good one already.
        if self._progress.stopped and self._progress.is_success:
            return
        with self._progress.stages.timed(CHECKS):
            self._make(found, farthest)

    def _make(self, found: Sequence[Candidate], farthest: float) -> None:
        progress = self._progress
        wanted = self._maker.options.num_answers + _SPARE_ANSWERS
        too_far = farthest * self._maker.objective.similar_distance
        nearest: Candidate | None = None
        num_feasible, answered = 0.0, set[Candidate]()
        untried = [candidate for candidate in found if candidate not in self.tried]
        # After a stop only the best one that can rest is finished, so that the stop is prompt.
        at_most = _CHECKS_AFTER_STOP if progress.stopped else _MAX_CHECKS
        for candidate in unlike(untried, self._maker.objective.extent)[:at_most]:
            if candidate.distance > too_far and nearest:
                break
            exact = self._rest.settled(candidate)
            self.tried.add(candidate)
            if exact is None:
                continue
            if nearest is None or self._search.doubt(exact) < self._search.doubt(nearest):
                nearest = exact
            if self._rest.stays(exact):
                answer = self._answer(exact)
                progress.add([answer])
                answered.add(exact)
                alike = self._appraisal.is_alike(exact)
                num_feasible += answer.feasible * _worth(steady=answer.steady, alike=alike)
            if num_feasible >= wanted or not progress.keep_going():
                break
        if nearest is not None and nearest not in answered and not progress.is_success:
            progress.add([self._attempt(nearest)])

    def _answer(self, exact: Candidate) -> ImitationAnswer:
        """Of a candidate that stays."""
        (answer,) = self._maker.answers(*self._search.tensors(exact))
        extra = self._appraisal.penalty(exact)
        if self._maker.is_success(answer):
            extra += self._appraisal.needless_turn(exact)
        return self._maker.handicapped(
            answer,
            # What else there is to choose from decides whether that matters.
            steady=self._progress.stopped or self._rest.is_steady(exact),
            alike=self._appraisal.is_alike(exact),
            difference=self._appraisal.difference(exact.proposal),
            extra=extra,
        )

    def _attempt(self, exact: Candidate) -> ImitationAnswer:
        """Of a candidate that may not stay, for want of a better one."""
        (answer,) = self._maker.answers(*self._search.tensors(exact))
        return self._maker.handicapped(
            answer,
            alike=self._appraisal.is_alike(exact),
            difference=self._appraisal.difference(exact.proposal),
            extra=self._search.doubt(exact),
        )


def _worth(*, steady: bool, alike: bool) -> float:
    """What a feasible answer counts towards those that are wanted."""
    return (1.0 if steady else _UNSTEADY_COUNT) * (1.0 if alike else _OTHERWISE_COUNT)
