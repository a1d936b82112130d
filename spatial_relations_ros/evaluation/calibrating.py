"""Knowing when the metric does not know: fitted on held-out scenes, measured on others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.evaluation.labelled_scenes import LabelledScenes, thin_rows
from spatial_relations_ros.learning import Calibration, RelationMetric
from spatial_relations_ros.learning.calibration import PRIOR

PROTOTYPES_PER_RELATION = 32
FALSE_ALARM_SHARE = 0.01
NUM_BINS = 15
_NUM_KNOTS = 64
# Pairs grow with the square, and clustering with the number, of scenes.
_MAX_HELD_OUT = 1500
_MAX_KNOWN = 4200
_CERTAINTY = 1e-3


@dataclass(frozen=True, eq=False)
class Pairs:
    """All pairs of some scenes.

    Attributes:
        distances: (P,).
        same: (P,) whether both show the same relation.
        weights: (P,) with a sum of one; same and different pairs weigh one half each, however
            many there are (the prior of :class:`Calibration`).
    """

    distances: NDArray[np.float64]
    same: NDArray[np.bool_]
    weights: NDArray[np.float64]

    @staticmethod
    def of(embeddings: NDArray[np.floating], labels: NDArray[np.integer]) -> Pairs | None:
        """The pairs of embeddings (S, D); None unless there are same and different ones."""
        first, second = np.triu_indices(len(labels), 1)
        same = labels[first] == labels[second]
        if not same.any() or same.all():
            return None
        exact = embeddings.astype(np.float64)
        squares = np.square(exact).sum(axis=1)
        gram = squares[:, None] + squares - 2.0 * exact @ exact.T
        distances = np.sqrt(np.maximum(gram[first, second], 0.0))
        weights = np.where(same, 0.5 / same.sum(), 0.5 / (~same).sum())
        return Pairs(distances, same, weights)


def calibrate(
    metric: RelationMetric, known: LabelledScenes, held_out: LabelledScenes
) -> Calibration | None:
    """What a metric's distances mean, from scenes of objects that it was not trained with.

    Args:
        metric: trained.
        known: the scenes that it was trained with.
        held_out: scenes of other objects.

    Returns:
        None when the held-out scenes have no pair of the same or no pair of different relations.
    """
    known, held_out = known.thinned(_MAX_KNOWN), held_out.thinned(_MAX_HELD_OUT)
    if not known.entries:
        return None
    return fit_calibration(
        known.embed(metric), known.labels, held_out.embed(metric), held_out.labels
    )


def fit_calibration(
    known: NDArray[np.floating],
    known_labels: NDArray[np.integer],
    held_out: NDArray[np.floating],
    labels: NDArray[np.integer],
) -> Calibration | None:
    """The same, of embeddings (K, D) and (S, D).

    Probabilities come from isotonic regression over all held-out pairs. Prototypes are the
    centres of k-means in each relation; 1 % of the held-out scenes are farther from all of them
    than the novelty distance.
    """
    pairs = Pairs.of(held_out, labels)
    if pairs is None:
        return None
    from sklearn.cluster import KMeans
    from sklearn.isotonic import IsotonicRegression

    isotonic = IsotonicRegression(increasing=False, out_of_bounds='clip')
    isotonic.fit(pairs.distances, pairs.same, sample_weight=pairs.weights)
    # More knots where scenes of the same relation lie.
    shares = np.linspace(0.0, 1.0, _NUM_KNOTS) ** 1.5
    knots = np.unique(np.quantile(pairs.distances, shares))
    knots = knots if len(knots) > 1 else knots[0] + np.array([0.0, 1.0])
    centres = []
    for label in np.unique(known_labels):
        members = known[known_labels == label].astype(np.float64)
        num_clusters = min(PROTOTYPES_PER_RELATION, len(np.unique(members, axis=0)))
        clusters = KMeans(num_clusters, n_init=2, random_state=0).fit(members)
        centres.append(clusters.cluster_centers_.astype(np.float32))
    measured = Calibration(
        knots,
        np.clip(isotonic.predict(knots), _CERTAINTY, 1.0 - _CERTAINTY).astype(np.float64),
        np.concatenate(centres),
        1.0,
    )
    threshold = float(np.quantile(measured.novelty(held_out), 1.0 - FALSE_ALARM_SHARE))
    return Calibration(
        measured.distances, measured.probabilities, measured.prototypes, max(threshold, 1e-6)
    )


def calibration_entry(calibration: Calibration | None) -> dict[str, Any]:
    """A calibration as it stands in a card."""
    if calibration is None:
        return {}
    return {
        'same_relation_distance': round(calibration.same_relation_distance, 4),
        'prior': PRIOR,
        'novelty_distance': round(calibration.novelty_distance, 4),
        'num_prototypes': len(calibration.prototypes),
    }


def measure_calibration(
    calibration: Calibration,
    embeddings: NDArray[np.floating],
    labels: NDArray[np.integer],
    nonsense: Mapping[str, NDArray[np.floating]],
) -> dict[str, Any]:
    """How far a calibration can be believed.

    Args:
        calibration: fitted on other scenes, or the numbers flatter it.
        embeddings: (S, D) of real scenes.
        labels: (S,) their relations.
        nonsense: embeddings (N, D) of scenes that cannot be, by kind.

    Returns:
        Ready for JSON; see ``docs/cli.md``.
    """
    reliability = measure_reliability(calibration, embeddings, labels)
    novelty = calibration.novelty(embeddings)
    strict = float(np.quantile(novelty, 1.0 - FALSE_ALARM_SHARE))
    scores = {kind: calibration.novelty(found) for kind, found in nonsense.items()}
    return {
        **calibration_entry(calibration),
        'reliability': reliability,
        'novelty': {
            'false_alarms': round(float((novelty > 1.0).mean()), 4),
            'detected': {kind: _share(score > 1.0) for kind, score in scores.items()},
            'detected_at_1_percent': {
                kind: _share(score > strict) for kind, score in scores.items()
            },
            'num_scenes': len(novelty),
            'num_nonsense': {kind: len(score) for kind, score in scores.items()},
        },
    }


def measure_reliability(
    calibration: Calibration, embeddings: NDArray[np.floating], labels: NDArray[np.integer]
) -> dict[str, Any] | None:
    """Predicted probabilities against what is so; None without both kinds of pairs.

    The expected calibration error is the mean difference of predicted and observed shares over
    15 equal bins of the predicted probability, weighted by how many pairs fall in (Guo et al.,
    ICML 2017), where same and different pairs weigh one half each.
    """
    rows = thin_rows(labels, _MAX_HELD_OUT)
    pairs = Pairs.of(embeddings[rows], labels[rows])
    if pairs is None:
        return None
    predicted = np.interp(pairs.distances, calibration.distances, calibration.probabilities)
    bins = np.minimum((predicted * NUM_BINS).astype(int), NUM_BINS - 1)
    shares, means, observed = (
        np.bincount(bins, weights=pairs.weights * values, minlength=NUM_BINS)
        for values in (1.0, predicted, pairs.same)
    )
    is_used = shares > 0.0
    right = (pairs.distances < calibration.same_relation_distance) == pairs.same
    return {
        'expected_calibration_error': round(float(np.abs(observed - means).sum()), 4),
        'accuracy': round(float(pairs.weights[right].sum()), 4),
        'num_pairs': len(predicted),
        'bins': [
            {'share': round(share, 4), 'predicted': round(p, 4), 'observed': round(o, 4)}
            for share, p, o in zip(
                shares[is_used].tolist(),
                (means[is_used] / shares[is_used]).tolist(),
                (observed[is_used] / shares[is_used]).tolist(),
                strict=True,
            )
        ],
    }


def _share(flags: NDArray[np.bool_]) -> float:
    return round(float(flags.mean()), 4)
