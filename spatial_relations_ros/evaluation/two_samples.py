"""How far two samples of points are apart: energy distance, a classifier, coverage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist
from sklearn.ensemble import ExtraTreesClassifier
from sklearn.model_selection import StratifiedKFold, cross_val_score

FloatArray = NDArray[np.float64]

_NUM_PERMUTATIONS = 200
_NUM_FOLDS = 5
_NUM_REPEATS = 2
_NUM_TREES = 60


@dataclass(frozen=True)
class EnergyDistance:
    """Energy distance of two samples, and what chance gives.

    Attributes:
        share: 2 E|X-Y| - E|X-X'| - E|Y-Y'| as a share of 2 E|X-Y|: 0 for equal distributions,
            1 for distant points (Szekely and Rizzo 2013).
        chance_95: its 95 % quantile when the samples are mixed at random.
    """

    share: float
    chance_95: float


def energy_distance(
    first: FloatArray, second: FloatArray, rng: np.random.Generator
) -> EnergyDistance:
    """Energy distance of points (N, D) and (M, D) with Euclidean distances."""
    both = np.concatenate([first, second])
    distances = cdist(both, both)
    rows = np.arange(len(both))
    share = _energy_share(distances, rows[: len(first)], rows[len(first) :])
    mixed = []
    for _ in range(_NUM_PERMUTATIONS):
        rng.shuffle(rows)
        mixed.append(_energy_share(distances, rows[: len(first)], rows[len(first) :]))
    return EnergyDistance(share, float(np.quantile(mixed, 0.95)))


def _energy_share(
    distances: FloatArray, first: NDArray[np.int64], second: NDArray[np.int64]
) -> float:
    between = distances[np.ix_(first, second)].mean()
    within = distances[np.ix_(first, first)].mean() + distances[np.ix_(second, second)].mean()
    return float(1.0 - within / (2.0 * max(between, 1e-12)))


def classifier_accuracy(
    first: FloatArray, second: FloatArray, *, seed: int
) -> tuple[float, float]:
    """Balanced accuracy of telling two samples apart: 0.5 when they are alike.

    Extremely randomised trees, five-fold cross-validation with new folds twice.

    Returns:
        Mean and standard deviation over the ten folds.
    """
    points = np.concatenate([first, second])
    labels = np.repeat([0, 1], [len(first), len(second)])
    scores = [
        cross_val_score(
            ExtraTreesClassifier(
                n_estimators=_NUM_TREES,
                min_samples_leaf=3,
                class_weight='balanced',
                random_state=seed,
            ),
            points,
            labels,
            scoring='balanced_accuracy',
            cv=StratifiedKFold(_NUM_FOLDS, shuffle=True, random_state=seed + repeat),
        )
        for repeat in range(_NUM_REPEATS)
    ]
    return float(np.mean(scores)), float(np.std(scores))


def nearest_distances(points: FloatArray, others: FloatArray) -> FloatArray:
    """Distance of each point (N, D) to the nearest of others (M, D)."""
    distances: FloatArray = cKDTree(others).query(points, k=1)[0]
    return distances


def spacing(points: FloatArray) -> FloatArray:
    """Distance of each point (N, D) to its nearest neighbour in the same sample."""
    distances: FloatArray = cKDTree(points).query(points, k=2)[0][:, 1]
    return distances


def covered(points: FloatArray, sample: FloatArray, *, quantile: float = 0.9) -> NDArray[np.bool_]:
    """Which points (N, D) are as near to a sample (M, D) as its own points are to each other.

    Nearer than the quantile of the sample's own spacing: of points of the same distribution that
    share is covered.
    """
    return np.asarray(nearest_distances(points, sample) <= np.quantile(spacing(sample), quantile))
