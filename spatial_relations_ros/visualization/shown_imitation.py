"""What there is to show of an imitation, apart from how: for report pages and animations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from spatial_relations_ros.core import Pose, Scene
from spatial_relations_ros.visualization.camera import outline_points

Poses = tuple[Pose, Pose]
"""world_from_object of base and relative."""


@dataclass(frozen=True)
class ShownStep:
    """A moment on the way to an answer.

    Attributes:
        poses: of base and relative.
        distance: of the best answer so far under the metric; None on a way that nobody measured.
        step: optimiser steps so far.
        feasible: whether nothing is violated; None when it was not checked.
    """

    poses: Poses
    distance: float | None = None
    step: int = 0
    feasible: bool | None = None


@dataclass(frozen=True)
class ShownCheck:
    """A row of the table of checks.

    Attributes:
        name: what was checked.
        value: what came out, in words.
        passed: None for a mere fact.
    """

    name: str
    value: str
    passed: bool | None = None


@dataclass(frozen=True)
class ShownAnswer:
    """One answer.

    Attributes:
        poses: targets of base and relative.
        distance: to the demonstration.
        feasible: whether nothing is violated.
        checks: what was checked.
        way: moments on the straight way there with their distances, start and end included;
            empty when nobody measured them.
    """

    poses: Poses
    distance: float
    feasible: bool
    checks: tuple[ShownCheck, ...] = ()
    way: tuple[ShownStep, ...] = ()


@dataclass(frozen=True, eq=False)
class ShownImitation:
    """An imitation to be shown.

    Attributes:
        title: of this one among several.
        reference: the demonstration.
        before: the test scene as it stood.
        answers: best first.
        steps: how the best answer so far changed; may be empty.
        history: (S,) distance at each step of the refinement.
        success: whether the best answer is good.
        message: what came out, in words.
        facts: name and value of what else is worth telling.
        table_height: world z of the table; the lowest point of the test objects by default.
    """

    title: str
    reference: Scene
    before: Scene
    answers: tuple[ShownAnswer, ...]
    steps: tuple[ShownStep, ...] = ()
    history: tuple[float, ...] = ()
    success: bool = False
    message: str = ''
    facts: tuple[tuple[str, str], ...] = ()
    table_height: float | None = None

    @property
    def start(self) -> Poses:
        """Poses of the test objects as they stood."""
        return self.before.base.world_from_object, self.before.relative.world_from_object

    @property
    def table(self) -> float:
        """World z of the table of the test scene."""
        return lowest_point(self.before) if self.table_height is None else self.table_height


def lowest_point(scene: Scene) -> float:
    """World z of the lowest point of both objects, metres."""
    return min(float(outline_points(item)[:, 2].min()) for item in scene.objects)


def way_to(shown: ShownImitation, answer_idx: int = 0) -> tuple[ShownStep, ...]:
    """The moments on the way from the start to an answer.

    For the best answer these are the recorded steps that changed something, if at least one
    lies between; else the measured way, or start and end alone.
    """
    answer = shown.answers[answer_idx]
    first = ShownStep(shown.start, shown.history[0] if shown.history else None)
    last = ShownStep(
        answer.poses,
        answer.distance,
        shown.steps[-1].step if shown.steps else 0,
        answer.feasible,
    )
    kept = [first]
    for step in (*(shown.steps if answer_idx == 0 else ()), last):
        if not _same(kept[-1].poses, step.poses):
            kept.append(step)
    return answer.way if len(kept) < 3 and answer.way else tuple(kept)


def straight_way(start: Poses, end: Poses, num_moments: int) -> list[Poses]:
    """Poses from start to end, both included, evenly apart."""
    return [
        (pose_between(start[0], end[0], share), pose_between(start[1], end[1], share))
        for share in (idx / (num_moments - 1) for idx in range(num_moments))
    ]


def pose_between(start: Pose, end: Pose, share: float) -> Pose:
    """The pose a share (0 to 1) of the way along a straight line and the shorter turn."""
    first, second = start.quat_wxyz, end.quat_wxyz
    cosine = float(np.dot(first, second))
    if cosine < 0.0:
        second, cosine = -second, -cosine
    angle = float(np.arccos(min(cosine, 1.0)))
    if angle < 1e-6:
        quat = first + share * (second - first)
    else:
        quat = (np.sin((1.0 - share) * angle) * first + np.sin(share * angle) * second) / np.sin(
            angle
        )
    translation = start.translation + share * (end.translation - start.translation)
    return Pose(translation, quat / np.linalg.norm(quat))


def _same(first: Sequence[Pose], second: Sequence[Pose]) -> bool:
    return all(
        one.is_close(other, metres=1e-5, angle_rad=1e-4)
        for one, other in zip(first, second, strict=True)
    )
