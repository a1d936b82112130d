"""From poses of the optimiser to checked, ranked and distinct answers."""

from __future__ import annotations

import dataclasses
import functools
import math

import numpy as np
import torch
from torch import Tensor

from spatial_relations_ros.core import Pose, Scene
from spatial_relations_ros.imitation.objective import Objective
from spatial_relations_ros.imitation.options import ImitationOptions
from spatial_relations_ros.imitation.placing import Placing
from spatial_relations_ros.imitation.pose_optimizer import evaluate
from spatial_relations_ros.imitation.poses import row_poses
from spatial_relations_ros.imitation.result import ImitationAnswer

# Among answers that are all but equal under the metric the nearest place wins.
_WAY_WEIGHT = 0.02
_LONG_WAY = 3.0
_UNSTEADY_WEIGHT = 0.4
_ANOTHER_PLACE = 0.5
# An attempt that falls, or is arranged otherwise, is worth less than one that is so much farther.
_DOUBTFUL = 0.8
_SAME_SHIFT = 0.1
_SAME_TURN_RAD = math.radians(20.0)


@dataclasses.dataclass(frozen=True, eq=False)
class AnswerMaker:
    """Turns poses into answers for one request."""

    test: Scene
    objective: Objective
    options: ImitationOptions
    movable: tuple[bool, bool]

    def rank(self, answers: list[ImitationAnswer]) -> list[ImitationAnswer]:
        """Best first: usable answers, then by distance, heading and how little is moved.

        Usable are feasible ones that are similar to the demonstration; when physics is left out
        feasibility does not count.
        """
        usable_below = (
            self.objective.similar_distance if self.options.physics_weight > 0.0 else None
        )
        return rank(answers, usable_below)

    def is_success(self, answer: ImitationAnswer) -> bool:
        """Whether an answer is feasible and similar to the demonstration."""
        return answer.feasible and answer.distance < self.objective.similar_distance

    def answers(self, rotations: Tensor, translations: Tensor) -> list[ImitationAnswer]:
        """Checked answers at exactly these poses, with distances as the metric reports them.

        Args:
            rotations: (K, 2, 3, 3) world from object, of base and relative.
            translations: (K, 2, 3) metres, from the objective's origin.
        """
        headings = self.objective.metric.card.headings
        batch = evaluate(self.objective, rotations, translations, headings=headings)
        made = [
            self._answer(row_poses(batch, row, self.objective.origin), float(batch.distances[row]))
            for row in range(len(batch.costs))
        ]
        return [self.handicapped(answer) for answer in made]

    @functools.cached_property
    def _placing(self) -> Placing:
        objective = self.objective
        return Placing(
            self.test, objective.shapes, self.movable, objective.table_height, self.options
        )

    def _answer(self, poses: tuple[Pose, Pose], distance: float) -> ImitationAnswer:
        placed = self._placing.at((self._target(0, poses[0]), self._target(1, poses[1])))
        return ImitationAnswer(
            placements=placed.placements,
            distance=distance,
            confidence=self.objective.confidence(distance, None),
            feasible=not placed.violations,
            violations=placed.violations,
            order=placed.order,
        )

    def _target(self, idx: int, pose: Pose) -> Pose:
        """Exactly the current pose of what may not move; else the nearer quaternion sign."""
        current = self.test.objects[idx].world_from_object
        if not self.movable[idx]:
            return current
        if float(current.quat_wxyz @ pose.quat_wxyz) < 0.0:
            return Pose(pose.translation, -pose.quat_wxyz)
        return pose

    def handicapped(
        self,
        answer: ImitationAnswer,
        *,
        steady: bool = True,
        alike: bool = True,
        difference: float | None = None,
        extra: float = 0.0,
    ) -> ImitationAnswer:
        """The answer with what ranking is to add to its distance, and what that says of it.

        Args:
            answer: made here.
            steady: whether it stays on a table that is tilted more.
            alike: whether its arrangement is the demonstration's.
            difference: how far it is from that, if that is known.
            extra: what is known about the placement besides.
        """
        weight, elsewhere = self.options.layout_weight, 0.0
        if weight > 0.0:
            elsewhere = float(self.objective.layout_difference(*self._tensors(answer))[0])
        if difference is not None:
            difference += elsewhere
        handicap = self._handicap(answer) + weight * elsewhere + extra
        return dataclasses.replace(
            answer,
            steady=steady,
            alike=alike and elsewhere <= _ANOTHER_PLACE,
            difference=difference,
            confidence=self.objective.confidence(answer.distance, difference),
            handicap=handicap + (0.0 if steady else _UNSTEADY_WEIGHT),
        )

    def _handicap(self, answer: ImitationAnswer) -> float:
        """For another heading than the demonstration's, and for long ways."""
        ways = [p.target.translation - p.current.translation for p in answer.placements]
        way = float(np.linalg.norm(ways, axis=1).sum()) / self.objective.extent
        penalty = float(self.objective.heading_penalty(*self._tensors(answer))[0])
        return penalty + _WAY_WEIGHT * min(way, _LONG_WAY)

    def _tensors(self, answer: ImitationAnswer) -> tuple[torch.Tensor, torch.Tensor]:
        """Rotations (1, 2, 3, 3) and translations (1, 2, 3) of an answer's targets."""
        targets = [placement.target for placement in answer.placements]
        rotations = np.array([[target.rotation for target in targets]])
        offsets = np.array([[target.translation - self.objective.origin for target in targets]])
        return torch.from_numpy(rotations).float(), torch.from_numpy(offsets).float()


def rank(answers: list[ImitationAnswer], usable_below: float | None) -> list[ImitationAnswer]:
    """Feasible answers nearer than ``usable_below`` first, alike ones before others.

    The nearest attempts follow. Without that distance feasibility does not count. Handicaps are
    added to distances.
    """

    def key(answer: ImitationAnswer) -> tuple[bool, bool, float]:
        usable = usable_below is None or (answer.feasible and answer.distance < usable_below)
        doubt = 0.0 if usable or (answer.feasible and answer.alike) else _DOUBTFUL
        return not usable, usable and not answer.alike, answer.distance + answer.handicap + doubt

    return sorted(answers, key=key)


def distinct(answers: list[ImitationAnswer], extent: float) -> list[ImitationAnswer]:
    """Drops answers that repeat an earlier one up to 10 % of the extent and 20 degrees."""
    kept: list[ImitationAnswer] = []
    for answer in answers:
        if not any(_is_same(answer, other, extent) for other in kept):
            kept.append(answer)
    return kept


def _is_same(first: ImitationAnswer, second: ImitationAnswer, extent: float) -> bool:
    return all(
        a.target.is_close(b.target, metres=_SAME_SHIFT * extent, angle_rad=_SAME_TURN_RAD)
        for a, b in zip(first.placements, second.placements, strict=True)
    )
