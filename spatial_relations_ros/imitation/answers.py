"""From poses of the optimiser to checked, ranked and distinct answers."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import torch

from spatial_relations_ros.core import Pose, Scene
from spatial_relations_ros.imitation.contact import Body, settle
from spatial_relations_ros.imitation.feasibility import check_placement
from spatial_relations_ros.imitation.objective import Objective
from spatial_relations_ros.imitation.options import ImitationOptions
from spatial_relations_ros.imitation.pose_optimizer import PoseBatch, evaluate
from spatial_relations_ros.imitation.result import (
    SIMILAR_DISTANCE,
    ImitationAnswer,
    ObjectPlacement,
)

_SAME_SHIFT = 0.1
_SAME_TURN_RAD = math.radians(20.0)
_QUICK_CHECKS = 4


@dataclasses.dataclass(frozen=True, eq=False)
class AnswerMaker:
    """Turns poses into answers for one request."""

    test: Scene
    objective: Objective
    options: ImitationOptions
    movable: tuple[bool, bool]

    def best_proposal(self, proposals: PoseBatch) -> ImitationAnswer:
        """The best of the nearest few proposals."""
        nearest = proposals.select(proposals.costs.argsort()[:_QUICK_CHECKS])
        return self.rank(self.answers(nearest))[0]

    def rank(self, answers: list[ImitationAnswer]) -> list[ImitationAnswer]:
        """Best first; by distance alone when physics is left out."""
        return rank(answers, physics=self.options.physics_weight > 0.0)

    def answers(self, batch: PoseBatch) -> list[ImitationAnswer]:
        """Checked answers at exactly these poses."""
        return [
            self._answer(_poses(batch, row), float(batch.distances[row]))
            for row in range(len(batch.costs))
        ]

    def settled_answers(self, batch: PoseBatch) -> list[ImitationAnswer]:
        """Checked answers after letting the moved objects down until they rest."""
        if self.options.physics_weight == 0.0:
            return self.answers(batch)
        pairs = [self._settled(_poses(batch, row)) for row in range(len(batch.costs))]
        rotations = np.array([[pose.rotation for pose in pair] for pair in pairs], np.float32)
        translations = np.array(
            [[pose.translation for pose in pair] for pair in pairs], np.float32
        )
        settled = evaluate(
            self.objective, torch.from_numpy(rotations), torch.from_numpy(translations)
        )
        return self.answers(settled)

    def _settled(self, poses: tuple[Pose, Pose]) -> tuple[Pose, Pose]:
        shapes, table = self.objective.shapes, self.objective.table_height
        base, relative = Body(shapes[0], poses[0]), Body(shapes[1], poses[1])
        if self.movable[0] and self.movable[1]:
            fall = float(base.world_points[:, 2].min()) - table
            shift = np.array([0.0, 0.0, -fall])
            base, relative = base.shifted(shift), relative.shifted(shift)
        if self.movable[1]:
            relative = settle(relative, base, table)
        else:
            base = settle(base, relative, table)
        return base.pose, relative.pose

    def _answer(self, poses: tuple[Pose, Pose], distance: float) -> ImitationAnswer:
        shapes = self.objective.shapes
        bodies = [Body(shape, pose) for shape, pose in zip(shapes, poses, strict=True)]
        placements: list[ObjectPlacement] = []
        violations: list[str] = []
        for k, item in enumerate(self.test.objects):
            other = self.test.objects[1 - k].object_id
            check = check_placement(
                item.object_id, bodies[k], other, bodies[1 - k], self.objective.table_height
            )
            if self.movable[k]:
                violations += check.violations
            lift = np.array([0.0, 0.0, self.options.approach_height])
            placements.append(
                ObjectPlacement(
                    object_id=item.object_id,
                    current=item.world_from_object,
                    target=poses[k],
                    approach=Pose(poses[k].translation + lift, poses[k].quat_wxyz),
                    reachable=True,
                    penetration=check.penetration,
                    supported=check.supported,
                )
            )
        return ImitationAnswer(
            placements=(placements[0], placements[1]),
            distance=distance,
            confidence=math.exp(-(distance**2)),
            feasible=not violations,
            violations=tuple(violations),
        )


def rank(answers: list[ImitationAnswer], *, physics: bool = True) -> list[ImitationAnswer]:
    """Feasible answers that are similar to the demonstration first, then the nearest attempts."""

    def key(answer: ImitationAnswer) -> tuple[bool, float]:
        usable = answer.feasible and answer.distance < SIMILAR_DISTANCE
        return physics and not usable, answer.distance

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


def _poses(batch: PoseBatch, row: int) -> tuple[Pose, Pose]:
    rotations = batch.rotations[row].double().numpy()
    translations = batch.translations[row].double().numpy()
    base, relative = (Pose.from_rotation(rotations[k], translations[k].tolist()) for k in (0, 1))
    return base, relative
