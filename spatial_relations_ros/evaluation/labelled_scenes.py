"""The labelled scenes of a dataset as rows of a matrix of embeddings."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import Scene, WeightsError
from spatial_relations_ros.datasets.freiburg import RelationDataset, RelationScene
from spatial_relations_ros.learning import RelationMetric

OnProgress = Callable[[int, int], None]

_CHUNK = 64
_UNEVEN_SHARE = 0.1


@dataclass(frozen=True, eq=False)
class LabelledScenes:
    """Scenes with labels; row numbers are places in ``entries``.

    Attributes:
        dataset: where they come from.
        entries: S scenes, each with a label.
    """

    dataset: RelationDataset
    entries: tuple[RelationScene, ...]

    @staticmethod
    def of(dataset: RelationDataset, names: Collection[str] | None = None) -> LabelledScenes:
        """All labelled scenes of a dataset, or those of these names."""
        return LabelledScenes(
            dataset,
            tuple(
                entry
                for entry in dataset.scenes
                if entry.label is not None and (names is None or entry.name in names)
            ),
        )

    @cached_property
    def labels(self) -> NDArray[np.int64]:
        """Values of :class:`Relation` (S,)."""
        return np.array(
            [int(entry.label) for entry in self.entries if entry.label is not None],
            dtype=np.int64,
        )

    @cached_property
    def _row_of(self) -> dict[str, int]:
        return {entry.name: row for row, entry in enumerate(self.entries)}

    def rows(self, names: Sequence[str]) -> NDArray[np.int64]:
        """Rows of scenes; names without a label are left out."""
        return np.array([self._row_of[name] for name in names if name in self._row_of], dtype=int)

    def scene(self, row: int) -> Scene:
        """The scene of a row."""
        return self.dataset.scene_of(self.entries[row])

    def thinned(self, at_most: int) -> LabelledScenes:
        """At most so many scenes, chosen by :func:`thin_rows`."""
        if len(self.entries) <= at_most:
            return self
        rows = thin_rows(self.labels, at_most)
        return LabelledScenes(self.dataset, tuple(self.entries[row] for row in rows))

    def chunks(self) -> Iterator[list[Scene]]:
        """The scenes in order, some at a time."""
        for first in range(0, len(self.entries), _CHUNK):
            entries = self.entries[first : first + _CHUNK]
            yield [self.dataset.scene_of(entry) for entry in entries]

    def embed(
        self, metric: RelationMetric, *, on_progress: OnProgress | None = None
    ) -> NDArray[np.float32]:
        """Embeddings (S, D); ``on_progress`` gets (scenes embedded, scenes in all).

        Raises:
            WeightsError: when the weights give numbers that are not finite.
        """
        embeddings = [np.zeros((0, metric.embedding_dim), dtype=np.float32)]
        done = 0
        for scenes in self.chunks():
            embeddings.append(metric.embed_scenes(scenes))
            if not np.isfinite(embeddings[-1]).all():
                raise WeightsError(
                    'the weights give embeddings that are not finite; train with a smaller '
                    'learning rate, in another run folder'
                )
            done += len(scenes)
            if on_progress is not None:
                on_progress(done, len(self.entries))
        return np.concatenate(embeddings)


def thin_rows(labels: NDArray[np.integer], at_most: int) -> NDArray[np.int64]:
    """At most so many rows, evenly over their order, with each label in about its share.

    Args:
        labels: (S,) not negative.
        at_most: rows.

    Returns:
        Rising row numbers.
    """
    count = min(len(labels), at_most)
    rows = np.linspace(0, len(labels) - 1, count).round().astype(np.int64)
    shares = np.bincount(labels) / max(len(labels), 1)
    kept = np.bincount(labels[rows], minlength=len(shares)) / max(count, 1)
    if np.all(np.abs(kept - shares) <= _UNEVEN_SHARE * shares):
        return rows
    # Labels that repeat in step with the rows, as in generated data: evenly within each label.
    by_label = np.argsort(labels, kind='stable')
    return np.sort(by_label[rows])
