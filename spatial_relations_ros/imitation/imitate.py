"""Imitation of a demonstrated relation with two other objects."""

from __future__ import annotations

import dataclasses
import time

import numpy as np
import torch

from spatial_relations_ros.core import ImitationError, Pose, Scene
from spatial_relations_ros.imitation.answers import AnswerMaker, distinct
from spatial_relations_ros.imitation.candidates import propose_poses
from spatial_relations_ros.imitation.contact import Body, lowest_point
from spatial_relations_ros.imitation.objective import Objective
from spatial_relations_ros.imitation.options import ROLES, ImitationOptions
from spatial_relations_ros.imitation.pose_optimizer import PoseBatch, evaluate, refine
from spatial_relations_ros.imitation.result import (
    SIMILAR_DISTANCE,
    ImitationAnswer,
    ImitationProgress,
    ImitationResult,
    ProgressCallback,
)
from spatial_relations_ros.imitation.shape import shape_of
from spatial_relations_ros.learning import RelationMetric
from spatial_relations_ros.projection import resample_points


def imitate(
    metric: RelationMetric,
    reference: Scene,
    test: Scene,
    options: ImitationOptions | None = None,
    *,
    on_progress: ProgressCallback | None = None,
) -> ImitationResult:
    """Finds poses of the test objects that imitate the relation of the reference objects.

    The i-th test object plays the part of the i-th reference object. Starting poses are proposed
    from the shapes, compared under the metric, refined by gradient descent through the metric
    (Jund et al. 2018, section III-C), let down until they rest, and checked.

    Args:
        metric: the learned metric; not used by another thread meanwhile.
        reference: the demonstration.
        test: the objects to place, where they stand now.
        options: settings; None for the defaults.
        on_progress: called after the proposals and after each step; returning False cancels.

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
        self.options, self.test, self.on_progress = options, test, on_progress
        self.objective = _make_objective(metric, reference, test, options)
        self.movable = (ROLES[0] in options.movable, ROLES[1] in options.movable)
        self.maker = AnswerMaker(test, self.objective, options, self.movable)
        self.cancelled = False
        self.num_steps = 0

    def run(self) -> ImitationResult:
        """Proposals, refinement, settling, checks."""
        current = evaluate(self.objective, *_pose_tensors([self.test]))
        initial_distance = float(current.distances[0])
        proposals = self._proposals(current)
        quick = self.maker.best_proposal(proposals)
        answers = [quick]
        history = np.array([initial_distance, quick.distance], dtype=np.float32)
        if self._report(0, quick.distance, quick) and self._has_time():
            starts = proposals.select(proposals.costs.argsort()[: self.options.num_starts])
            refined, distances = refine(
                self.objective,
                starts,
                self.movable,
                steps=self.options.max_steps,
                learning_rate=self.options.learning_rate,
                on_step=lambda step, best: self._on_step(step, best, quick),
            )
            answers += self.maker.settled_answers(refined) + self.maker.answers(starts)
            answers += self.maker.settled_answers(_moved_only(refined, starts))
            winner = int(refined.costs.argmin())
            history = np.concatenate([[initial_distance], distances[:, winner].numpy()])
        ranked = distinct(self.maker.rank(answers), self.objective.extent)[
            : self.options.num_answers
        ]
        return self._result(tuple(ranked), history.astype(np.float32), initial_distance)

    def _proposals(self, current: PoseBatch) -> PoseBatch:
        """The current poses and, when asked for, those proposed from the shapes."""
        if not self.options.propose:
            return current
        moving = 1 if self.movable[1] else 0
        bodies = [Body(shape_of(item), item.world_from_object) for item in self.test.objects]
        poses = propose_poses(bodies[moving], bodies[1 - moving], self.objective.table_height)
        scenes = [self.test]
        for pose in poses:
            pair = [item.world_from_object for item in self.test.objects]
            pair[moving] = pose
            scenes.append(self.test.with_poses(*pair))
        return evaluate(self.objective, *_pose_tensors(scenes))

    def _has_time(self) -> bool:
        budget = self.options.time_budget_sec
        return not budget or time.monotonic() - self.start_time < budget

    def _report(self, step: int, distance: float, best: ImitationAnswer) -> bool:
        if self.on_progress is None:
            return True
        progress = ImitationProgress(step, distance, best.feasible, best)
        self.cancelled = not self.on_progress(progress)
        return not self.cancelled

    def _on_step(self, step: int, best: PoseBatch, answer: ImitationAnswer) -> bool:
        self.num_steps = step
        return self._report(step, float(best.distances.min()), answer) and self._has_time()

    def _result(
        self,
        answers: tuple[ImitationAnswer, ...],
        history: np.ndarray[tuple[int, ...], np.dtype[np.float32]],
        initial_distance: float,
    ) -> ImitationResult:
        best = answers[0]
        success = best.feasible and best.distance < SIMILAR_DISTANCE
        return ImitationResult(
            success=success,
            message=_message(best, initial_distance, self.cancelled),
            answers=answers,
            distance_history=history,
            initial_distance=initial_distance,
            duration_sec=time.monotonic() - self.start_time,
            num_steps=self.num_steps,
            cancelled=self.cancelled,
        )


def _make_objective(
    metric: RelationMetric, reference: Scene, test: Scene, options: ImitationOptions
) -> Objective:
    sizes = [float(np.linalg.norm(np.ptp(item.points, axis=0))) for item in test.objects]
    extent = sum(sizes)
    if not 1e-4 < extent < 1e3:
        raise ImitationError(
            f'the test objects are {sizes[0]:.3g} m and {sizes[1]:.3g} m large; '
            'clouds and poses must be in metres'
        )
    shapes = tuple(shape_of(item) for item in test.objects)
    bodies = [
        Body(shape, item.world_from_object)
        for shape, item in zip(shapes, test.objects, strict=True)
    ]
    table = options.table_height
    clouds = np.stack([resample_points(item.points, metric.num_points) for item in test.objects])
    return Objective(
        metric=metric,
        clouds=torch.from_numpy(clouds),
        shapes=(shapes[0], shapes[1]),
        reference_embedding=torch.from_numpy(metric.embed_scenes([reference])[0]),
        extent=extent,
        table_height=lowest_point(bodies) if table is None else table,
        physics_weight=options.physics_weight,
        heading=_heading(reference) if options.keep_heading else None,
    )


def _heading(reference: Scene) -> torch.Tensor | None:
    """Horizontal direction from the base's to the relative object's middle, if there is one."""
    base, relative = (item.world_points.mean(axis=0)[:2] for item in reference.objects)
    offset = relative - base
    length = float(np.linalg.norm(offset))
    return torch.from_numpy(offset / length) if length > 1e-3 else None


def _pose_tensors(scenes: list[Scene]) -> tuple[torch.Tensor, torch.Tensor]:
    """Rotations (K, 2, 3, 3) and translations (K, 2, 3) of scenes."""
    poses: list[list[Pose]] = [[o.world_from_object for o in s.objects] for s in scenes]
    rotations = np.array([[pose.rotation for pose in pair] for pair in poses], np.float32)
    translations = np.array([[pose.translation for pose in pair] for pair in poses], np.float32)
    return torch.from_numpy(rotations), torch.from_numpy(translations)


def _moved_only(refined: PoseBatch, starts: PoseBatch) -> PoseBatch:
    """Refined positions with the orientations of the starts, which rested on their faces."""
    return dataclasses.replace(refined, rotations=starts.rotations)


def _message(best: ImitationAnswer, initial_distance: float, cancelled: bool) -> str:
    fell = f'distance {initial_distance:.2f} before, {best.distance:.2f} after'
    if cancelled:
        return f'cancelled; best answer so far: {fell}'
    if best.distance >= SIMILAR_DISTANCE:
        return (
            f'no placement was found that is similar to the demonstration: {fell}; '
            f'similar relations lie below {SIMILAR_DISTANCE:g}'
        )
    if not best.feasible:
        return f'no feasible placement was found; the nearest: {"; ".join(best.violations)}'
    return fell
