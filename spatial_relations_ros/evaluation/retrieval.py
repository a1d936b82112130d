"""Retrieval: are the nearest scenes of the same relation?

Source: Jund et al. 2018, section IV-A. For each test scene the five nearest training scenes are
looked up; ``3-of-5`` counts the test scenes for which at least three of them show the same
relation, ``5-of-5`` those for which all do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import DatasetFormatError, Relation

NUM_NEIGHBOURS = 5


@dataclass(frozen=True, eq=False)
class RetrievalResult:
    """Retrieval numbers of one split.

    Attributes:
        three_of_five: share of test scenes, 0 to 1.
        five_of_five: share of test scenes, 0 to 1.
        mean_average_precision: over test scenes, 0 to 1.
        confusion: (7, 7) counts: true relation by the majority relation of the five neighbours.
        num_queries: test scenes.
        num_gallery: training scenes.
    """

    three_of_five: float
    five_of_five: float
    mean_average_precision: float
    confusion: NDArray[np.int64]
    num_queries: int
    num_gallery: int


def evaluate_embeddings(
    gallery: NDArray[np.floating],
    gallery_labels: NDArray[np.integer],
    queries: NDArray[np.floating],
    query_labels: NDArray[np.integer],
) -> RetrievalResult:
    """Retrieval numbers of embeddings.

    Args:
        gallery: (G, D) embeddings of training scenes, G >= 5.
        gallery_labels: (G,).
        queries: (Q, D) embeddings of test scenes, Q >= 1; none of them is in the gallery.
        query_labels: (Q,).

    Raises:
        DatasetFormatError: when there are too few scenes.
    """
    check_enough(len(gallery), len(queries))
    order = ranked(gallery, queries)
    matches = gallery_labels[order] == query_labels[:, None]
    hits = matches[:, :NUM_NEIGHBOURS].sum(axis=1)
    confusion = np.zeros((len(Relation), len(Relation)), dtype=np.int64)
    for label, row in zip(query_labels, gallery_labels[order[:, :NUM_NEIGHBOURS]], strict=True):
        confusion[label, np.bincount(row, minlength=len(Relation)).argmax()] += 1
    return RetrievalResult(
        three_of_five=float((hits >= 3).mean()),
        five_of_five=float((hits == NUM_NEIGHBOURS).mean()),
        mean_average_precision=float(_average_precision(matches).mean()),
        confusion=confusion,
        num_queries=len(queries),
        num_gallery=len(gallery),
    )


def check_enough(num_gallery: int, num_queries: int) -> None:
    """Checks that there are scenes to look up, and enough among which to look.

    Raises:
        DatasetFormatError: when there are not.
    """
    if num_gallery < NUM_NEIGHBOURS or num_queries < 1:
        raise DatasetFormatError(
            f'{num_queries} test and {num_gallery} training scenes with labels; retrieval needs '
            f'at least 1 and {NUM_NEIGHBOURS}'
        )


def ranked(gallery: NDArray[np.floating], queries: NDArray[np.floating]) -> NDArray[np.int64]:
    """Rows (Q, G) of the gallery (G, D) for each query (Q, D), nearest first."""
    squared = (
        np.square(queries).sum(1)[:, None]
        + np.square(gallery).sum(1)[None]
        - 2.0 * queries @ gallery.T
    )
    return np.argsort(squared, axis=1, kind='stable')


def _average_precision(matches: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Average precision of each ranked row of matches; rows without a match count zero."""
    ranks = np.arange(1, matches.shape[1] + 1)
    precision = np.cumsum(matches, axis=1) / ranks
    averages: NDArray[np.float64] = (precision * matches).sum(axis=1)
    averages /= np.maximum(matches.sum(axis=1), 1)
    return averages
