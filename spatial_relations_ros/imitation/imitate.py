"""Imitation of a demonstrated relation with two other objects."""

from __future__ import annotations

import dataclasses
import itertools
import math
import time

import numpy as np
import torch

from spatial_relations_ros.core import ImitationError, Scene
from spatial_relations_ros.imitation.answers import AnswerMaker, distinct, pose_tensors
from spatial_relations_ros.imitation.candidates import propose_poses
from spatial_relations_ros.imitation.contact import Body, lowest_point
from spatial_relations_ros.imitation.objective import Objective
from spatial_relations_ros.imitation.options import ROLES, ImitationOptions
from spatial_relations_ros.imitation.pose_optimizer import (
    PoseBatch,
    concatenate,
    evaluate,
    refine,
)
from spatial_relations_ros.imitation.result import (
    ImitationAnswer,
    ImitationProgress,
    ImitationResult,
    ProgressCallback,
)
from spatial_relations_ros.imitation.shape import shape_of
from spatial_relations_ros.learning import RelationMetric
from spatial_relations_ros.projection import resample_points

_CHUNK = 16
_QUICK_CHECKS = 4
_STEPS_A_CHECK = 8
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

    The i-th test object plays the part of the i-th reference object. Starting poses are proposed
    from the shapes, compared under the metric, refined by gradient descent through the metric
    (Jund et al. 2018, section III-C), let down until they rest, and checked.

    Args:
        metric: the learned metric; not used by another thread meanwhile.
        reference: the demonstration.
        test: the objects to place, where they stand now.
        options: settings; None for the defaults.
        on_progress: called after each handful of proposals and after each step; returning False
            cancels.

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
        self.answers: list[ImitationAnswer] = []
        self.best: ImitationAnswer
        self.cancelled = self.stopped = False
        self.num_steps = 0

    def run(self) -> ImitationResult:
        """Proposals, refinement, settling, checks; at every moment there is a best answer."""
        current = evaluate(self.objective, *pose_tensors([self.test], self.objective.origin))
        self._add(self.maker.answers(current))
        initial_distance = self.best.distance
        proposals = self._proposals(current)
        nearest = proposals.costs.argsort()
        if not self.stopped:
            self._add(self.maker.answers(proposals.select(nearest[:_QUICK_CHECKS])))
        history = [initial_distance, self.best.distance]
        if self._keep_going(0):
            starts = proposals.select(nearest[: self.options.num_starts])
            history = [initial_distance, *self._refine(starts)]
        ranked = distinct(self.maker.rank(self.answers), self.objective.extent)
        return self._result(tuple(ranked[: self.options.num_answers]), history)

    def _proposals(self, current: PoseBatch) -> PoseBatch:
        """The current poses and, when asked for, those proposed from the shapes."""
        if not self.options.propose:
            return current
        moving = 1 if self.movable[1] else 0
        bodies = [Body(shape_of(item), item.world_from_object) for item in self.test.objects]
        poses = propose_poses(bodies[moving], bodies[1 - moving], self.objective.table_height)
        batches = [current]
        while self._keep_going(0) and (chunk := list(itertools.islice(poses, _CHUNK))):
            scenes = []
            for pose in chunk:
                pair = [item.world_from_object for item in self.test.objects]
                pair[moving] = pose
                scenes.append(self.test.with_poses(*pair))
            batches.append(evaluate(self.objective, *pose_tensors(scenes, self.objective.origin)))
        return concatenate(batches)

    def _refine(self, starts: PoseBatch) -> list[float]:
        """Descends from all starts; returns the distances of the one that ends best."""
        refined, distances = refine(
            self.objective,
            starts,
            self.movable,
            steps=self.options.max_steps,
            learning_rate=self.options.learning_rate,
            on_step=self._on_step,
        )
        order = refined.costs.argsort()
        moved_only = dataclasses.replace(refined, rotations=starts.rotations)
        for count, row in enumerate(order):
            # After a stop only the best one is finished, so that the stop is prompt.
            if count and (self.stopped or not self._keep_going(self.num_steps)):
                break
            chosen = row[None]
            self._add(self.maker.settled_answers(refined.select(chosen)))
            if not self.stopped:
                # Starts rest on their faces; refinement tilts a little.
                self._add(self.maker.settled_answers(moved_only.select(chosen)))
                self._add(self.maker.answers(starts.select(chosen)))
        history: list[float] = distances[:, int(order[0])].tolist()
        return history

    def _on_step(self, step: int, best: PoseBatch) -> bool:
        self.num_steps = step
        if step % _STEPS_A_CHECK == 0:
            self._add(self.maker.settled_answers(best.select(best.costs.argmin()[None])))
        return self._keep_going(step)

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
        is_late = time.monotonic() - self.start_time > _BUDGET_SHARE * budget
        self.stopped = self.stopped or self.cancelled or is_late
        return not self.stopped

    def _result(
        self,
        answers: tuple[ImitationAnswer, ...],
        history: list[float],
    ) -> ImitationResult:
        best = answers[0]
        similar_distance = self.objective.similar_distance
        success = best.feasible and best.distance < similar_distance
        return ImitationResult(
            success=success,
            message=_message(best, history[0], similar_distance, cancelled=self.cancelled),
            answers=answers,
            distance_history=np.array(history, dtype=np.float32),
            initial_distance=history[0],
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
        origin=np.array(test.base.world_from_object.translation),
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


def _message(
    best: ImitationAnswer, initial_distance: float, similar_distance: float, *, cancelled: bool
) -> str:
    fell = f'distance {initial_distance:.2f} before, {best.distance:.2f} after'
    if cancelled:
        return f'cancelled; best answer so far: {fell}'
    if best.distance >= similar_distance:
        return (
            f'no placement was found that is similar to the demonstration: {fell}; '
            f'similar relations lie below {similar_distance:.2f}'
        )
    if not best.feasible:
        return f'no feasible placement was found; the nearest: {"; ".join(best.violations)}'
    return fell
