"""How long the memory of relations takes to find the nearest of many: times on this machine.

``python -m spatial_relations_ros.evaluation.memory_benchmark --scenes 100000`` fills a file in a
temporary folder with that many remembered scenes and prints medians and 90th percentiles.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.progress import track

from spatial_relations_ros.core import Pose, Scene, SceneObject
from spatial_relations_ros.memory import RelationMemory
from spatial_relations_ros.memory.scene_rows import insert_objects
from spatial_relations_ros.memory.schema import open_database, transaction

EMBEDDING_DIM = 64
POINTS_PER_OBJECT = 256
_MODEL = 'benchmark'
_BATCH = 2000


def fill(path: Path, num_scenes: int, rng: np.random.Generator) -> None:
    """Remembers scenes of random clouds and embeddings, many in a transaction."""
    points = rng.normal(size=(POINTS_PER_OBJECT, 3)).astype(np.float32)
    scene = Scene(SceneObject('base', points, Pose()), SceneObject('relative', points, Pose()))
    connection = open_database(path)
    for first in track(range(0, num_scenes, _BATCH), description='scenes stored'):
        with transaction(connection):
            for idx in range(first, min(first + _BATCH, num_scenes)):
                vector = rng.normal(size=EMBEDDING_DIM).astype('<f4')
                row = connection.execute(
                    'INSERT INTO relations (name, frame_id, stamp_ns, model_hash, embedding) '
                    'VALUES (?, ?, ?, ?, ?)',
                    (f'scene {idx}', 'world', 0, _MODEL, vector.tobytes()),
                )
                insert_objects(connection, int(row.lastrowid or 0), scene)
    connection.close()


def measure(path: Path, *, runs: int, rng: np.random.Generator) -> dict[str, Any]:
    """Milliseconds of opening with the first search, of searches, and of searches after a write.

    The last are with a write of this process, and with one of another connection, before each.
    """
    points = np.zeros((POINTS_PER_OBJECT, 3), dtype=np.float32)
    scene = Scene(SceneObject('base', points, Pose()), SceneObject('relative', points, Pose()))

    def vector() -> np.ndarray:
        return rng.normal(size=EMBEDDING_DIM).astype(np.float32)

    start = time.perf_counter()
    with RelationMemory(path) as memory, RelationMemory(path) as other:
        memory.nearest(vector(), 5, _MODEL)
        first = 1e3 * (time.perf_counter() - start)

        def search() -> None:
            memory.nearest(vector(), 5, _MODEL)

        def write(store: RelationMemory) -> Callable[[], None]:
            return lambda: store.remember('new', scene, vector(), _MODEL, replace=True)

        return {
            'first_ms': round(first, 1),
            'nearest': _times(search, runs),
            'nearest_after_own_write': _times(search, runs, before=write(memory)),
            'nearest_after_other_write': _times(search, runs, before=write(other)),
            'remember': _times(write(memory), runs),
        }


def _times(
    step: Callable[[], None], runs: int, *, before: Callable[[], None] = lambda: None
) -> dict[str, float]:
    milliseconds = []
    for _ in range(runs):
        before()
        start = time.perf_counter()
        step()
        milliseconds.append(1e3 * (time.perf_counter() - start))
    return {
        'median_ms': round(float(np.median(milliseconds)), 2),
        'p90_ms': round(float(np.quantile(milliseconds, 0.9)), 2),
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Prints the times as JSON; returns the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').partition('\n')[0])
    parser.add_argument('--scenes', type=int, default=100_000)
    parser.add_argument('--runs', type=int, default=50)
    parser.add_argument('--seed', type=int, default=0)
    options = parser.parse_args(arguments)
    rng = np.random.default_rng(options.seed)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'relations.sqlite3'
        fill(path, options.scenes, rng)
        megabytes = path.stat().st_size / 1e6
        times = measure(path, runs=options.runs, rng=rng)
    print(json.dumps({'scenes': options.scenes, 'file_mb': round(megabytes), **times}, indent=1))
    return 0


if __name__ == '__main__':
    sys.exit(main())
