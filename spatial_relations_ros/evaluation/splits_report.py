"""Retrieval over the splits of a dataset."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import DatasetFormatError, Relation
from spatial_relations_ros.datasets.freiburg import RelationDataset, Split
from spatial_relations_ros.evaluation.labelled_scenes import LabelledScenes, OnProgress
from spatial_relations_ros.evaluation.retrieval import (
    RetrievalResult,
    check_enough,
    evaluate_embeddings,
)
from spatial_relations_ros.learning import RelationMetric

PROTOCOLS = ('scene', 'object')

Space = Callable[[NDArray[np.int64]], NDArray[np.floating]]
"""Embeddings (S, D) of all scenes, given the rows of a split's training scenes: a metric that was
trained before ignores those, one that is fitted to the split uses nothing but those."""


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
        """Means and standard deviations over splits (None of a single one), ready for JSON."""
        summary: dict[str, Any] = {
            'protocol': _counted(len(self.results), f'{self.protocol} split'),
            'num_queries': int(sum(result.num_queries for result in self.results)),
        }
        for name in ('three_of_five', 'five_of_five', 'mean_average_precision'):
            values = np.array([getattr(result, name) for result in self.results])
            summary[name] = round(float(values.mean()), 4)
            summary[f'{name}_std'] = (
                round(float(values.std(ddof=1)), 4) if len(values) > 1 else None
            )
        return summary


def retrieve(
    metric: RelationMetric,
    dataset: RelationDataset,
    *,
    protocol: str = 'scene',
    on_progress: OnProgress | None = None,
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
    splits = splits_of(dataset, protocol)
    scenes = LabelledScenes.of(dataset)
    embeddings = scenes.embed(metric, on_progress=on_progress)
    return evaluate_splits(lambda _: embeddings, scenes, splits, protocol=protocol)


def splits_of(dataset: RelationDataset, protocol: str) -> Sequence[Split]:
    """The splits of a protocol.

    Raises:
        DatasetFormatError: when the dataset has none.
    """
    splits = dataset.splits if protocol == 'scene' else dataset.object_splits
    if protocol not in PROTOCOLS or not splits:
        raise DatasetFormatError(
            f'the dataset has no {protocol} splits; it has {len(dataset.splits)} scene splits '
            f'and {len(dataset.object_splits)} object splits'
        )
    return splits


def check_splits(dataset: RelationDataset) -> None:
    """Checks that retrieval can run over all splits of a dataset, before anything is computed.

    Raises:
        DatasetFormatError: when it has no splits, or a split with too few labelled scenes.
    """
    if not (dataset.splits or dataset.object_splits):
        splits_of(dataset, PROTOCOLS[0])
    scenes = LabelledScenes.of(dataset)
    for protocol, splits in zip(PROTOCOLS, (dataset.splits, dataset.object_splits), strict=True):
        for split in splits:
            try:
                check_enough(len(scenes.rows(split.train)), len(scenes.rows(split.test)))
            except DatasetFormatError as error:
                raise DatasetFormatError(f'{protocol} {split.name}: {error}') from error


def evaluate_splits(
    space: Space, scenes: LabelledScenes, splits: Sequence[Split], *, protocol: str
) -> SplitsReport:
    """Retrieval over splits in the space that each split's training scenes give."""
    results = []
    for split in splits:
        gallery, queries = scenes.rows(split.train), scenes.rows(split.test)
        embeddings = space(gallery)
        results.append(
            evaluate_embeddings(
                embeddings[gallery],
                scenes.labels[gallery],
                embeddings[queries],
                scenes.labels[queries],
            )
        )
    return SplitsReport(protocol, tuple(results))


def _counted(number: int, what: str) -> str:
    return f'{number} {what}' if number == 1 else f'{number} {what}s'


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
