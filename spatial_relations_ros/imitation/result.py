"""What an imitation returns."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import Pose, Scene
from spatial_relations_ros.imitation.manipulation import Move


@dataclass(frozen=True)
class ObjectPlacement:
    """Where one test object should go.

    Attributes:
        object_id: of the object.
        current: world_from_object before.
        target: world_from_object that imitates the demonstration.
        approach: pre-place pose, from which a straight way leads to the target: from above, or
            from where the way is free.
        reachable: whether one arm reaches where it is, the approach and the target; True when no
            arm is described.
        penetration: deepest overlap with the other object, the table or obstacles, metres.
        supported: whether contacts below carry its centre of mass.
        approach_clear: whether nothing stands in the way from approach to target; True for an
            object that does not move.
        gripper_target: world_from_gripper at the target; None without a grasp.
        gripper_approach: the same at the approach pose.
    """

    object_id: str
    current: Pose
    target: Pose
    approach: Pose
    reachable: bool
    penetration: float
    supported: bool
    approach_clear: bool = True
    gripper_target: Pose | None = None
    gripper_approach: Pose | None = None


@dataclass(frozen=True)
class ImitationAnswer:
    """One way to imitate the demonstration.

    Attributes:
        placements: of base and relative.
        distance: to the demonstration under the metric.
        confidence: probability that the demonstration is imitated, as the judge of the benchmarks
            would say, from distance and difference by the calibration of answers in the card of
            the weights; without one, of the same relation by the calibration of the weights, else
            exp(-distance^2).
        feasible: whether nothing is violated.
        violations: what is, in words.
        steady: whether it would stay on a table tilted by 8 degrees too, rather than by 4, and
            not roll there.
        alike: whether offset, lean, overhang and depth are those of the demonstration too; True
            where they are not known, as without meshes.
        difference: how far those are off together: a half for each that is as far off as another
            way to show the relation; None where they are not known.
        handicap: what ranking adds to the distance: for another heading, layout or lean than the
            demonstration's, a bare balance, long ways.
        order: how to carry it out, step by step; empty when nothing moves, or when neither object
            could be placed before the other one.
    """

    placements: tuple[ObjectPlacement, ObjectPlacement]
    distance: float
    confidence: float
    feasible: bool
    violations: tuple[str, ...]
    order: tuple[Move, ...] = ()
    steady: bool = True
    alike: bool = True
    difference: float | None = None
    handicap: float = 0.0

    def scene(self, test: Scene) -> Scene:
        """The test scene with the objects at this answer's poses."""
        base, relative = self.placements
        return test.with_poses(base.target, relative.target)


@dataclass(frozen=True, eq=False)
class ImitationResult:
    """Outcome of one imitation.

    Attributes:
        success: whether the best answer is feasible and similar to the demonstration, that is
            nearer than the distance at which that is likely.
        message: why not, in words a person can act on; otherwise a summary.
        answers: best first; at least one. Not by the distance alone: what stays only just, rolls
            or moves far counts as a little farther.
        distance_history: (S,) distance of the best answer's run at each step; the first is the
            test scene as it stands.
        initial_distance: distance of the test scene as it stands.
        duration_sec: wall time.
        num_steps: optimiser steps of the refinement.
        cancelled: whether the caller asked to stop.
        stage_seconds: wall time of each part of the work, by name.
    """

    success: bool
    message: str
    answers: tuple[ImitationAnswer, ...]
    distance_history: NDArray[np.float32]
    initial_distance: float
    duration_sec: float
    num_steps: int
    cancelled: bool = False
    stage_seconds: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class ImitationProgress:
    """Where a running imitation stands.

    Attributes:
        step: optimiser steps so far.
        distance, feasible: of the best answer so far.
        best: that answer.
    """

    step: int
    distance: float
    feasible: bool
    best: ImitationAnswer


ProgressCallback = Callable[[ImitationProgress], bool]
