"""From poses of the optimiser to checked, ranked and distinct answers."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray

from spatial_relations_ros.core import Pose, Scene
from spatial_relations_ros.imitation.contact import Body, settle
from spatial_relations_ros.imitation.feasibility import check_placement
from spatial_relations_ros.imitation.objective import Objective
from spatial_relations_ros.imitation.options import ImitationOptions
from spatial_relations_ros.imitation.pose_optimizer import PoseBatch, evaluate
from spatial_relations_ros.imitation.result import ImitationAnswer, ObjectPlacement

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
        """Best first; by distance alone when physics is left out."""
        usable_below = (
            self.objective.similar_distance if self.options.physics_weight > 0.0 else None
        )
        return rank(answers, usable_below)

    def answers(self, batch: PoseBatch) -> list[ImitationAnswer]:
        """Checked answers at exactly these poses, with distances as the metric reports them."""
        headings = self.objective.metric.card.headings
        if headings > 1:
            batch = evaluate(
                self.objective, batch.rotations, batch.translations, headings=headings
            )
        return [
            self._answer(_poses(batch, row, self.objective.origin), float(batch.distances[row]))
            for row in range(len(batch.costs))
        ]

    def settled_answers(self, batch: PoseBatch) -> list[ImitationAnswer]:
        """Checked answers after letting the moved objects down until they rest."""
        if self.options.physics_weight == 0.0:
            return self.answers(batch)
        origin = self.objective.origin
        pairs = [self._settled(_poses(batch, row, origin)) for row in range(len(batch.costs))]
        scenes = [self.test.with_poses(*pair) for pair in pairs]
        return self.answers(evaluate(self.objective, *pose_tensors(scenes, origin)))

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
        poses = (self._target(0, poses[0]), self._target(1, poses[1]))
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
            confidence=self.objective.confidence(distance),
            feasible=not violations,
            violations=tuple(violations),
        )

    def _target(self, idx: int, pose: Pose) -> Pose:
        """Exactly the current pose of what may not move; else the nearer quaternion sign."""
        current = self.test.objects[idx].world_from_object
        if not self.movable[idx]:
            return current
        if float(current.quat_wxyz @ pose.quat_wxyz) < 0.0:
            return Pose(pose.translation, -pose.quat_wxyz)
        return pose


def rank(answers: list[ImitationAnswer], usable_below: float | None) -> list[ImitationAnswer]:
    """Feasible answers nearer than ``usable_below`` first, then the nearest attempts.

    Without that distance feasibility does not count.
    """

    def key(answer: ImitationAnswer) -> tuple[bool, float]:
        usable = usable_below is None or (answer.feasible and answer.distance < usable_below)
        return not usable, answer.distance

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


def pose_tensors(
    scenes: Sequence[Scene], origin: NDArray[np.float64]
) -> tuple[torch.Tensor, torch.Tensor]:
    """Rotations (K, 2, 3, 3) and translations (K, 2, 3), from an origin (3,), of scenes."""
    poses = [[item.world_from_object for item in scene.objects] for scene in scenes]
    rotations = np.array([[pose.rotation for pose in pair] for pair in poses])
    translations = np.array([[pose.translation - origin for pose in pair] for pair in poses])
    return torch.from_numpy(rotations).float(), torch.from_numpy(translations).float()


def _poses(batch: PoseBatch, row: int, origin: NDArray[np.float64]) -> tuple[Pose, Pose]:
    rotations = batch.rotations[row].double().numpy()
    translations = batch.translations[row].double().numpy() + origin
    base, relative = (Pose.from_rotation(rotations[k], translations[k]) for k in (0, 1))
    return base, relative
