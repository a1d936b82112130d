"""Whether pose optimisation brings displaced objects back, with a gradient of the projection."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np
import roma
import torch
from scipy.spatial import cKDTree
from torch import Tensor

from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.evaluation.gradient_agreement import Motion, MotionDistance
from spatial_relations_ros.evaluation.gradient_cases import DisplacedScene, Variant
from spatial_relations_ros.learning import RelationMetric

STEPS = 60
# Peak step of Adam: a share of the scene's extent, and radians. Decays to a tenth along a cosine.
_LEARNING_RATE = 0.03
# An object is back when its error is below this share of the scene's extent.
BACK_WITHIN = 0.03
_UNCALIBRATED_SIMILAR_DISTANCE = 0.5
_SURFACE_POINTS = 150
_MAX_HEADING_DEG, _NUM_HEADINGS = 60.0, 13
# Every so many steps the error is taken.
_CHECK_STEPS = 4


@dataclass(frozen=True)
class Descent:
    """One optimisation, from the displaced scene to the nearest (or last) scene that it saw.

    Attributes:
        distances: from the demonstration, at the start and at the end.
        errors: of the pose, see :class:`PoseError`, at the start and at the end.
        is_back: whether the end's error is below ``BACK_WITHIN`` and its distance below the one
            that the calibration asks of the same relation.
        back_after: steps until the error stayed that low, in fours.
        milliseconds: of CPU time, of a step, median.
    """

    distances: tuple[float, float]
    errors: tuple[float, float]
    is_back: bool
    back_after: int
    milliseconds: float


def descend(
    metric: RelationMetric, case: DisplacedScene, variant: Variant, *, steps: int = STEPS
) -> Descent:
    """Adam on the pose of the displaced object, under the metric alone."""
    motion = torch.zeros(6, requires_grad=True)
    adam = torch.optim.Adam([motion], lr=_LEARNING_RATE)
    least, best = math.inf, motion.detach().clone()
    bests: list[Motion] = [best]
    milliseconds = []
    distance = MotionDistance(metric, case)
    with metric.projecting(**variant.settings):
        for step in range(steps):
            variant.narrow(metric, step / steps)
            start = time.process_time()
            adam.param_groups[0]['lr'] = _LEARNING_RATE * (
                0.55 + 0.45 * math.cos(math.pi * step / steps)
            )
            value = distance(motion)
            adam.zero_grad(set_to_none=True)
            torch.autograd.backward(value)
            # Distances at different widths cannot be compared: then the last scene counts.
            if variant.narrows or float(value.detach()) < least:
                least, best = float(value.detach()), motion.detach().clone()
            adam.step()
            milliseconds.append(1e3 * (time.process_time() - start))
            if (step + 1) % _CHECK_STEPS == 0:
                bests.append(best)
    with torch.no_grad():
        distances = float(distance(bests[0])), float(distance(best))
    error_of = PoseError(case)
    errors = [error_of(motion) for motion in bests]
    far = [check for check, error in enumerate(errors) if error >= BACK_WITHIN]
    return Descent(
        distances=distances,
        errors=(errors[0], errors[-1]),
        is_back=errors[-1] < BACK_WITHIN and distances[1] < _similar_distance(metric),
        back_after=_CHECK_STEPS * (far[-1] + 1) if far else 0,
        milliseconds=float(np.median(milliseconds)),
    )


class PoseError:
    """How far a motion leaves the relative object from where it was, seen from the base.

    ADD-S: the mean distance of surface points from the nearest point of where their object was,
    summed over both objects, as a share of the scene's extent. The metric does not tell headings
    apart, so the smallest over turns of the whole scene about the vertical counts.
    """

    def __init__(self, case: DisplacedScene) -> None:
        items = case.reference.objects
        self._extent = case.extent
        self._pivot = items[0].world_points.mean(axis=0, dtype=np.float64)
        self._trees = [cKDTree(item.world_points) for item in items]
        base, relative = (item.world_points.astype(np.float64) for item in case.scene.objects)
        self._base = base[:: max(len(base) // _SURFACE_POINTS, 1)]
        self._middle = relative.mean(axis=0)
        self._relative = relative[:: max(len(relative) // _SURFACE_POINTS, 1)]
        headings = np.radians(np.linspace(-_MAX_HEADING_DEG, _MAX_HEADING_DEG, _NUM_HEADINGS))
        self._turns = np.stack([matrix_from_rotvec(np.array([0.0, 0.0, a])) for a in headings])

    def __call__(self, motion: Tensor) -> float:
        """The error after a motion as :class:`MotionDistance` takes it."""
        turn = roma.rotvec_to_rotmat(motion[3:].double()).numpy()
        shift = motion[:3].double().numpy() * self._extent
        moved = (self._relative - self._middle) @ turn.T + self._middle + shift
        total = np.zeros(len(self._turns))
        for points, tree in zip((self._base, moved), self._trees, strict=True):
            gaps, _ = tree.query((points - self._pivot) @ self._turns + self._pivot)
            total += gaps.mean(axis=1)
        return float(total.min()) / self._extent


def _similar_distance(metric: RelationMetric) -> float:
    if metric.calibration is None:
        return _UNCALIBRATED_SIMILAR_DISTANCE
    return metric.calibration.same_relation_distance
