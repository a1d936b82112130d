"""Agreement of a gradient of the projection with finite differences of the metric."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import roma
import torch
from numpy.typing import NDArray
from torch import Tensor

from spatial_relations_ros.evaluation.gradient_cases import DisplacedScene, Variant
from spatial_relations_ros.learning import RelationMetric, euclidean_distance
from spatial_relations_ros.projection import ProjectionConfig

# About two pixels: smaller steps would measure the rounding to pixels.
_STEPS = (0.02, 0.03, 0.04)

Motion = Tensor  # (6,): shift as a share of the scene's extent, then a rotation vector (rad)
Slopes = NDArray[np.float64]  # (6,)


class MotionDistance:
    """Distance to the demonstration when the displaced object makes a further motion.

    The demonstration is embedded with the projection that the metric has at the time.
    """

    def __init__(self, metric: RelationMetric, case: DisplacedScene) -> None:
        self._metric, self._extent = metric, case.extent
        self._reference_points = torch.from_numpy(metric.scene_points(case.reference))[None]
        self._base, relative = torch.from_numpy(metric.scene_points(case.scene))
        self._middle = relative.mean(dim=0)
        self._relative = relative - self._middle
        self._references: dict[ProjectionConfig, Tensor] = {}

    def __call__(self, motion: Motion) -> Tensor:
        """The distance; differentiable."""
        turned = self._relative @ roma.rotvec_to_rotmat(motion[3:]).T
        moved = turned + self._middle + motion[:3] * self._extent
        embedding = self._metric.embed(torch.stack([self._base, moved])[None])[0]
        return euclidean_distance(embedding, self._reference())

    def _reference(self) -> Tensor:
        projection = self._metric.encoder.projection
        if projection not in self._references:
            with torch.no_grad():
                self._references[projection] = self._metric.embed(self._reference_points)[0]
        return self._references[projection]


def finite_differences(distance: MotionDistance) -> Slopes:
    """Central differences, mean over steps."""
    slopes = np.zeros(6)
    with torch.no_grad():
        for axis in range(6):
            unit = torch.eye(6)[axis]
            slopes[axis] = np.mean(
                [float(distance(s * unit) - distance(-s * unit)) / (2.0 * s) for s in _STEPS]
            )
    return slopes


def analytic_slopes(metric: RelationMetric, case: DisplacedScene, variant: Variant) -> Slopes:
    """The variant's gradient."""
    with metric.projecting(**variant.settings):
        motion = torch.zeros(6, requires_grad=True)
        (gradient,) = torch.autograd.grad(MotionDistance(metric, case)(motion), motion)
    return gradient.double().numpy()


def agreement(
    numeric: Sequence[Slopes], analytic: Sequence[Slopes]
) -> dict[str, dict[str, float]]:
    """Correlation, its 95 % interval over cases, and share of equal signs, of shifts and turns.

    Signs are compared where the slope is above its median; the interval is a bootstrap's.
    """
    truth, found = np.array(numeric), np.array(analytic)
    return {
        'shift': _agreement(truth[:, :3], found[:, :3]),
        'turn': _agreement(truth[:, 3:], found[:, 3:]),
    }


def _agreement(truth: NDArray[np.float64], found: NDArray[np.float64]) -> dict[str, float]:
    rng = np.random.default_rng(0)
    resampled = []
    for _ in range(1000):
        rows = rng.integers(0, len(truth), len(truth))
        resampled.append(_correlation(truth[rows], found[rows]))
    steep = np.abs(truth) > np.median(np.abs(truth))
    low, high = np.quantile(resampled, [0.025, 0.975])
    return {
        'correlation': _correlation(truth, found),
        'correlation_low': float(low),
        'correlation_high': float(high),
        'equal_sign': float((np.sign(truth) == np.sign(found))[steep].mean()),
    }


def _correlation(truth: NDArray[np.float64], found: NDArray[np.float64]) -> float:
    return float(np.corrcoef(truth.ravel(), found.ravel())[0, 1])
