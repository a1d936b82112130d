"""How many scenes of a dataset stay as they are when they are let go (MuJoCo)."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from spatial_relations_ros.core import DatasetFormatError, Relation, atomic_write
from spatial_relations_ros.datasets.freiburg import RelationDataset, RelationScene, load_dataset
from spatial_relations_ros.evaluation.intervals import wilson_interval
from spatial_relations_ros.placement.body import Body, Placed
from spatial_relations_ros.placement.model import ObjectModel
from spatial_relations_ros.placement.physics import Motion, settle

_DENSITY = 1000.0


@dataclass(frozen=True)
class Settled:
    """A scene and how its objects moved."""

    name: str
    relation: Relation | None
    base: Motion
    relative: Motion

    @property
    def stayed(self) -> bool:
        """Whether both stayed."""
        return self.base.stayed and self.relative.stayed


def settle_scenes(
    dataset: RelationDataset,
    scenes: Sequence[RelationScene],
    *,
    on_progress: Callable[[int], None] | None = None,
) -> list[Settled]:
    """Lets scenes go on a table under their lowest point; all of one density.

    Raises:
        DatasetFormatError: for objects without a mesh.
        ConfigError: where MuJoCo is not installed.
    """
    bodies: dict[str, Body] = {}
    settled = []
    for scene in scenes:
        for name in (scene.base_id, scene.relative_id):
            if name not in dataset.meshes:
                raise DatasetFormatError(f'{scene.name}: no mesh of {name}, only meshes can fall')
            if name not in bodies:
                mesh = dataset.meshes[name]
                bodies[name] = Body.of(ObjectModel(name, '', mesh, {}, None, _DENSITY))
        placed = [
            Placed(bodies[name], pose.rotation, np.asarray(pose.translation))
            for name, pose in (
                (scene.base_id, scene.world_from_base),
                (scene.relative_id, scene.world_from_relative),
            )
        ]
        lowest = min(float(body.world_vertices[:, 2].min()) for body in placed)
        lifted = [body.moved(np.array([0.0, 0.0, -lowest])) for body in placed]
        motions = settle(lifted)
        settled.append(Settled(scene.name, scene.label, *motions))
        if on_progress is not None:
            on_progress(len(settled))
    return settled


def summarize(settled: Sequence[Settled]) -> dict[str, dict[str, object]]:
    """Counts by relation and over all, with 95 % Wilson intervals."""
    groups = {
        relation.name.lower(): [entry for entry in settled if entry.relation is relation]
        for relation in Relation
    }
    groups['all'] = list(settled)
    return {
        name: {
            'scenes': len(entries),
            'stayed': sum(entry.stayed for entry in entries),
            'wilson_95': [
                round(value, 3)
                for value in wilson_interval(sum(entry.stayed for entry in entries), len(entries))
            ],
        }
        for name, entries in groups.items()
        if entries
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Prints the counts; returns the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').partition('\n')[0])
    parser.add_argument('folder', type=Path, help='of a dataset with meshes')
    parser.add_argument('--scenes', type=int, default=140, help='the first so many')
    parser.add_argument('--json', type=Path)
    options = parser.parse_args(arguments)
    dataset = load_dataset(options.folder)
    scenes = [scene for scene in dataset.scenes if scene.label is not None][: options.scenes]
    settled = settle_scenes(dataset, scenes)
    summary = summarize(settled)
    for name, numbers in summary.items():
        print(f'{name}: {numbers}')
    if options.json is not None:
        moved = [entry.name for entry in settled if not entry.stayed]
        with atomic_write(options.json) as temporary:
            temporary.write_text(json.dumps({'summary': summary, 'moved': moved}, indent=2) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
