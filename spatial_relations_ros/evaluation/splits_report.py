"""Retrieval of a metric over the splits of a dataset."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import DatasetFormatError, Relation
from spatial_relations_ros.datasets.freiburg import RelationDataset, Split
from spatial_relations_ros.evaluation.retrieval import RetrievalResult, evaluate_embeddings
from spatial_relations_ros.learning import RelationMetric

PROTOCOLS = ('scene', 'object')
_CHUNK = 64


@dataclass(frozen=True, eq=False)
class SplitsReport:
    """Retrieval over all splits of one protocol.

    Attributes:
        protocol: ``scene`` (the paper's) or ``object`` (no test object in a gallery scene).
        results: one for each split.
        confusion: (7, 7) counts summed over splits, true relation by majority of neighbours.
    """

    protocol: str
    results: tuple[RetrievalResult, ...]

    @property
    def confusion(self) -> NDArray[np.int64]:
        """See the class."""
        return np.asarray(sum(result.confusion for result in self.results))

    def summary(self) -> dict[str, Any]:
        """Means and standard deviations over splits, ready for JSON."""
        summary: dict[str, Any] = {
            'protocol': f'{len(self.results)} {self.protocol} splits',
            'num_queries': int(sum(result.num_queries for result in self.results)),
        }
        for name in ('three_of_five', 'five_of_five', 'mean_average_precision'):
            values = np.array([getattr(result, name) for result in self.results])
            summary[name] = round(float(values.mean()), 4)
            summary[f'{name}_std'] = (
                round(float(values.std(ddof=1)), 4) if len(values) > 1 else 0.0
            )
        return summary


def retrieve(
    metric: RelationMetric,
    dataset: RelationDataset,
    *,
    protocol: str = 'scene',
    on_progress: Callable[[int, int], None] | None = None,
) -> SplitsReport:
    """Looks up the nearest scenes of each split's test scenes under a metric.

    Args:
        metric: not trained on these scenes, or the numbers mean little.
        dataset: labelled scenes with splits.
        protocol: which splits, ``scene`` or ``object``.
        on_progress: called with (scenes embedded, scenes in all).

    Raises:
        DatasetFormatError: when the dataset has no such split, or too few labelled scenes.
    """
    splits = dataset.splits if protocol == 'scene' else dataset.object_splits
    if protocol not in PROTOCOLS or not splits:
        raise DatasetFormatError(
            f'the dataset has no {protocol} splits; it has {len(dataset.splits)} scene splits '
            f'and {len(dataset.object_splits)} object splits'
        )
    labelled = [entry for entry in dataset.scenes if entry.label is not None]
    embeddings = []
    for first in range(0, len(labelled), _CHUNK):
        chunk = [dataset.scene_of(entry) for entry in labelled[first : first + _CHUNK]]
        embeddings.append(metric.embed_scenes(chunk))
        if on_progress is not None:
            on_progress(min(first + _CHUNK, len(labelled)), len(labelled))
    rows = {entry.name: row for row, entry in enumerate(labelled)}
    labels = np.array([int(entry.label) for entry in labelled if entry.label is not None])
    stacked = np.concatenate(embeddings) if embeddings else np.zeros((0, metric.embedding_dim))
    return evaluate_splits(stacked, labels, rows, splits, protocol=protocol)


def evaluate_splits(
    embeddings: NDArray[np.floating],
    labels: NDArray[np.integer],
    rows: dict[str, int],
    splits: Sequence[Split],
    *,
    protocol: str,
) -> SplitsReport:
    """Retrieval of given embeddings (S, D) over splits; ``rows`` maps scene names to rows."""
    results = []
    for split in splits:
        gallery = np.array([rows[name] for name in split.train if name in rows], dtype=int)
        queries = np.array([rows[name] for name in split.test if name in rows], dtype=int)
        results.append(
            evaluate_embeddings(
                embeddings[gallery], labels[gallery], embeddings[queries], labels[queries]
            )
        )
    return SplitsReport(protocol, tuple(results))


def confusion_by_name(confusion: NDArray[np.int64]) -> dict[str, dict[str, int]]:
    """A confusion matrix as a dictionary of relation names, without zeros."""
    return {
        truth.name: {
            found.name: int(confusion[truth, found])
            for found in Relation
            if confusion[truth, found]
        }
        for truth in Relation
    }
