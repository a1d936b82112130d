"""Pictures of how metrics retrieve: maps, confusion matrices, nearest neighbours."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import Relation
from spatial_relations_ros.datasets.freiburg import Split
from spatial_relations_ros.evaluation.comparison import ComparedMetric
from spatial_relations_ros.evaluation.labelled_scenes import LabelledScenes
from spatial_relations_ros.evaluation.retrieval import NUM_NEIGHBOURS, ranked
from spatial_relations_ros.evaluation.splits_report import splits_of
from spatial_relations_ros.visualization import (
    Image,
    ShownScene,
    draw_confusion,
    draw_embedding_map,
    draw_neighbour_sheet,
    render_scene,
    write_image,
)

OnPicture = Callable[[int, int], None]

SHEET_ROWS = 8
THUMBNAILS_PER_RELATION = 2
_MAX_MAPPED = 2000
_WIDTH, _HEIGHT = 280, 210


class SceneGallery:
    """Renders scenes, each once.

    Args:
        scenes: the dataset's.
        on_picture: called with (scenes rendered, scenes that will be, as far as is known).
    """

    def __init__(
        self, scenes: LabelledScenes, num_expected: int, on_picture: OnPicture | None = None
    ) -> None:
        self._scenes = scenes
        self._pictures: dict[int, Image] = {}
        self._num_expected = num_expected
        self._on_picture = on_picture

    def picture(self, row: int) -> Image:
        """The scene of a row, (210, 280, 3)."""
        if row not in self._pictures:
            objects = self._scenes.scene(row).objects
            self._pictures[row] = render_scene(objects, width=_WIDTH, height=_HEIGHT)
            if self._on_picture is not None:
                done = len(self._pictures)
                self._on_picture(done, max(done, self._num_expected))
        return self._pictures[row]


def write_retrieval_pictures(
    folder: Path,
    compared: Sequence[ComparedMetric],
    scenes: LabelledScenes,
    *,
    seed: int,
    on_picture: OnPicture | None = None,
) -> list[Path]:
    """Writes pictures of every metric; returns their paths.

    ``<name>_<protocol>_confusion.png`` for all, and for learned metrics ``<name>_map.png`` (t-SNE
    of all scenes, at most 2,000 of them) and ``<name>_neighbours.png`` (test scenes of the last
    protocol's first split, those with the most wrong neighbours first).

    Args:
        folder: is made.
        compared: results.
        scenes: that they were measured on.
        seed: of t-SNE.
        on_picture: called as scenes are rendered, which takes the time.
    """
    learned = [item for item in compared if item.embeddings is not None]
    num_each = SHEET_ROWS * (NUM_NEIGHBOURS + 1) + THUMBNAILS_PER_RELATION * len(Relation)
    gallery = SceneGallery(scenes, num_each * len(learned), on_picture)
    paths = []
    for item in compared:
        stem = re.sub(r'[^\w.-]+', '_', item.name)
        for protocol, report in item.reports.items():
            title = f'{item.name}: {len(report.results)} {protocol} splits'
            paths.append(
                write_image(
                    folder / f'{stem}_{protocol}_confusion.png',
                    draw_confusion(report.confusion, title=title),
                )
            )
    for item in learned:
        assert item.embeddings is not None
        stem = re.sub(r'[^\w.-]+', '_', item.name)
        split = splits_of(scenes.dataset, list(item.reports)[-1])[0]
        sheet = neighbour_sheet(item.embeddings, scenes, split, gallery)
        paths.append(write_image(folder / f'{stem}_neighbours.png', sheet))
        picture = embedding_map(item.embeddings, scenes, gallery, name=item.name, seed=seed)
        paths.append(write_image(folder / f'{stem}_map.png', picture))
    return paths


def neighbour_sheet(
    embeddings: NDArray[np.floating], scenes: LabelledScenes, split: Split, gallery: SceneGallery
) -> Image:
    """Test scenes with their five nearest training scenes, the worst first."""
    train, test = scenes.rows(split.train), scenes.rows(split.test)
    order = ranked(embeddings[train], embeddings[test])[:, :NUM_NEIGHBOURS]
    offsets = embeddings[train[order]] - embeddings[test][:, None]
    distances = np.linalg.norm(offsets, axis=-1)
    hits = (scenes.labels[train[order]] == scenes.labels[test][:, None]).sum(axis=1)
    return draw_neighbour_sheet(
        [
            [
                _shown(scenes, int(test[query]), None, gallery),
                *(
                    _shown(scenes, int(train[place]), float(distance), gallery)
                    for place, distance in zip(order[query], distances[query], strict=True)
                ),
            ]
            for query in worst_first(hits, scenes.labels[test])[:SHEET_ROWS]
        ]
    )


def worst_first(hits: NDArray[np.int64], labels: NDArray[np.int64]) -> list[int]:
    """Queries by how few neighbours are right, relations taking turns among equals."""
    turns = np.zeros(len(hits), dtype=np.int64)
    for label in np.unique(labels):
        members = np.flatnonzero(labels == label)
        turns[members[np.argsort(hits[members], kind='stable')]] = np.arange(len(members))
    return [int(row) for row in np.lexsort((labels, turns, hits))]


def _shown(
    scenes: LabelledScenes, row: int, distance: float | None, gallery: SceneGallery
) -> ShownScene:
    return ShownScene(gallery.picture(row), Relation(int(scenes.labels[row])), distance)


def embedding_map(
    embeddings: NDArray[np.floating],
    scenes: LabelledScenes,
    gallery: SceneGallery,
    *,
    name: str,
    seed: int,
) -> Image:
    """A map of the scenes by t-SNE (van der Maaten and Hinton, JMLR 2008)."""
    from sklearn.manifold import TSNE

    count = min(len(embeddings), _MAX_MAPPED)
    rows = np.linspace(0, len(embeddings) - 1, count).round().astype(int)
    perplexity = min(30.0, (count - 1) / 3.0)
    tsne = TSNE(2, perplexity=perplexity, init='pca', random_state=seed)
    places = tsne.fit_transform(embeddings[rows].astype(np.float64))
    labels = scenes.labels[rows]
    chosen = [int(row) for label in np.unique(labels) for row in _typical(places, labels == label)]
    return draw_embedding_map(
        places,
        labels,
        thumbnails={row: gallery.picture(int(rows[row])) for row in chosen},
        title=f'{name}: {count} scenes, t-SNE of the embedding (seed {seed})',
    )


def _typical(places: NDArray[np.floating], members: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Rows of members: the most central one, then those farthest from the chosen ones."""
    rows = np.flatnonzero(members)
    middle = np.median(places[rows], axis=0)
    chosen = [int(np.linalg.norm(places[rows] - middle, axis=1).argmin())]
    while len(chosen) < min(THUMBNAILS_PER_RELATION, len(rows)):
        gaps = np.linalg.norm(places[rows][:, None] - places[rows[chosen]], axis=-1).min(axis=1)
        chosen.append(int(gaps.argmax()))
    return rows[chosen]
