"""How well the projection's gradients agree with finite differences of the metric.

    python -m spatial_relations_ros.evaluation.gradients DATA --cases 60

Each case is a demonstration and a displaced copy of it. The metric's distance is differentiated
by the six degrees of freedom of the relative object, with each gradient of the projection, and
compared with central differences over steps of about two pixels, which smooth the rounding.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import roma
import torch
from numpy.typing import NDArray
from torch import Tensor

from spatial_relations_ros.core import Scene, atomic_write
from spatial_relations_ros.datasets.freiburg import RelationDataset, load_dataset
from spatial_relations_ros.learning import RelationMetric, euclidean_distance, load_metric
from spatial_relations_ros.projection.config import GRADIENTS

_STEPS = (0.02, 0.03, 0.04)
_MAX_SHIFT = 0.15
_MAX_TURN_RAD = math.radians(30.0)

Motion = Tensor  # (6,): shift as a share of the scene's extent, then a rotation vector (rad)


def compare_gradients(
    metric: RelationMetric, dataset: RelationDataset, *, num_cases: int, seed: int
) -> dict[str, Any]:
    """Agreement of each gradient with finite differences.

    Returns:
        For each gradient: correlation with finite differences and share of equal signs (where
        the slope is not small), for shifts and for turns, and milliseconds of an evaluation with
        its gradient (median, 90th percentile).
    """
    rng = np.random.default_rng(seed)
    rows = rng.choice(len(dataset.scenes), num_cases, replace=False)
    numeric = []
    analytic: dict[str, list[NDArray[np.float64]]] = {name: [] for name in GRADIENTS}
    times: dict[str, list[float]] = {name: [] for name in GRADIENTS}
    shipped = metric.encoder.projection
    for row in rows:
        distance = _displaced(metric, dataset.scene_of(dataset.scenes[row]), rng)
        numeric.append(_finite_differences(distance))
        for name in GRADIENTS:
            metric.encoder.projection = dataclasses.replace(shipped, gradient=name)
            start = time.perf_counter()
            analytic[name].append(_gradient(distance))
            times[name].append(1e3 * (time.perf_counter() - start))
    metric.encoder.projection = shipped
    return {
        name: {
            **_agreement(np.array(numeric), np.array(analytic[name])),
            'milliseconds_median': round(float(np.median(times[name])), 2),
            'milliseconds_p90': round(float(np.quantile(times[name], 0.9)), 2),
        }
        for name in GRADIENTS
    }


def _displaced(
    metric: RelationMetric, scene: Scene, rng: np.random.Generator
) -> Callable[[Motion], Tensor]:
    """Distance to a scene of its copy, displaced at random and then by a motion."""
    points = torch.from_numpy(metric.scene_points(scene))
    reference = torch.from_numpy(metric.embed_scenes([scene])[0])
    extent = float((points.flatten(0, 1).amax(0) - points.flatten(0, 1).amin(0)).max())
    middle = 0.5 * (points[1].amax(0) + points[1].amin(0))
    shift = torch.from_numpy(rng.uniform(-_MAX_SHIFT, _MAX_SHIFT, 3).astype(np.float32))
    turn = torch.from_numpy(rng.uniform(-_MAX_TURN_RAD, _MAX_TURN_RAD, 3).astype(np.float32))
    displaced = (points[1] - middle) @ roma.rotvec_to_rotmat(turn).T

    def distance(motion: Motion) -> Tensor:
        turned = displaced @ roma.rotvec_to_rotmat(motion[3:]).T
        moved = turned + middle + (shift + motion[:3]) * extent
        embedding = metric.embed(torch.stack([points[0], moved])[None])[0]
        return euclidean_distance(embedding, reference)

    return distance


def _finite_differences(distance: Callable[[Motion], Tensor]) -> NDArray[np.float64]:
    slopes = np.zeros(6)
    with torch.no_grad():
        for axis in range(6):
            unit = torch.eye(6)[axis]
            slopes[axis] = np.mean(
                [float(distance(s * unit) - distance(-s * unit)) / (2.0 * s) for s in _STEPS]
            )
    return slopes


def _gradient(distance: Callable[[Motion], Tensor]) -> NDArray[np.float64]:
    motion = torch.zeros(6, requires_grad=True)
    (gradient,) = torch.autograd.grad(distance(motion), motion)
    return gradient.double().numpy()


def _agreement(numeric: NDArray[np.float64], analytic: NDArray[np.float64]) -> dict[str, float]:
    agreement = {}
    for name, axes in (('shift', slice(0, 3)), ('turn', slice(3, 6))):
        truth, found = numeric[:, axes].ravel(), analytic[:, axes].ravel()
        steep = np.abs(truth) > np.median(np.abs(truth))
        agreement[f'{name}_correlation'] = round(float(np.corrcoef(truth, found)[0, 1]), 3)
        agreement[f'{name}_equal_sign'] = round(
            float((np.sign(truth) == np.sign(found))[steep].mean()), 3
        )
    return agreement


def main(arguments: Sequence[str] | None = None) -> int:
    """Prints the comparison; returns the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').partition('\n')[0])
    parser.add_argument('data', type=Path, help='a generated dataset')
    parser.add_argument('--weights', type=Path, help='instead of those shipped')
    parser.add_argument('--cases', type=int, default=60)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--json', type=Path)
    options = parser.parse_args(arguments)
    metric = load_metric(options.weights)
    report = compare_gradients(
        metric, load_dataset(options.data), num_cases=options.cases, seed=options.seed
    )
    for name, numbers in report.items():
        print(name, ', '.join(f'{key} {value}' for key, value in numbers.items()))
    if options.json is not None:
        with atomic_write(options.json) as temporary:
            temporary.write_text(json.dumps({'cases': options.cases, **report}, indent=2) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
