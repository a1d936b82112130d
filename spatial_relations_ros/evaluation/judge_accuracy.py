"""How often the judge names the relation that a generated scene was made for.

    python -m spatial_relations_ros.evaluation.judge_accuracy DATA --pictures wrong.png

The judge sees meshes and poses only. Its answers are compared with the labels, which the
generator's own placing and checking code gave.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.progress import track

from spatial_relations_ros import __version__
from spatial_relations_ros.core import DatasetFormatError, Relation, Scene, atomic_write
from spatial_relations_ros.datasets.freiburg import RelationDataset, load_dataset
from spatial_relations_ros.evaluation.intervals import wilson_interval
from spatial_relations_ros.evaluation.judging import Judgement, judge_scene
from spatial_relations_ros.visualization import contact_sheet, render_scene, write_image

_MAX_PICTURES = 40


@dataclass(frozen=True, eq=False)
class JudgedScene:
    """A labelled scene and what the judge says of it."""

    name: str
    label: Relation
    judgement: Judgement

    @property
    def is_right(self) -> bool:
        """Whether the judge agrees with the label."""
        return self.judgement.relation is self.label


def judge_dataset(dataset: RelationDataset, *, num_scenes: int | None = None) -> list[JudgedScene]:
    """Judges the labelled scenes of a dataset, the first ``num_scenes`` of them.

    Raises:
        DatasetFormatError: when there are none, or none with meshes.
    """
    entries = [
        entry
        for entry in dataset.scenes
        if entry.label is not None and {entry.base_id, entry.relative_id} <= set(dataset.meshes)
    ][:num_scenes]
    if not entries:
        raise DatasetFormatError(
            f'none of the {len(dataset.scenes)} scenes has a label and meshes of both objects'
        )
    judged = []
    for entry in track(entries, 'judging'):
        assert entry.label is not None
        judgement = judge_scene(dataset.scene_of(entry))
        judged.append(JudgedScene(entry.name, entry.label, judgement))
    return judged


def summarize(judged: Sequence[JudgedScene]) -> dict[str, Any]:
    """Accuracy overall and by relation with 95 % intervals, and what was taken for what."""
    table: dict[str, Any] = {}
    for name in ('all', *(relation.name for relation in Relation)):
        chosen = [scene for scene in judged if name in ('all', scene.label.name)]
        if not chosen:
            continue
        right = sum(scene.is_right for scene in chosen)
        table[name] = {
            'scenes': len(chosen),
            'right': right,
            'accuracy': round(right / len(chosen), 4),
            'wilson_95': [round(bound, 4) for bound in wilson_interval(right, len(chosen))],
        }
    confusions: dict[str, int] = {}
    for scene in judged:
        if not scene.is_right:
            answer = scene.judgement.relation
            key = f'{scene.label.name} as {"none" if answer is None else answer.name}'
            confusions[key] = confusions.get(key, 0) + 1
    return {'accuracy': table, 'confusions': dict(sorted(confusions.items()))}


def draw_disagreements(path: Path, dataset: RelationDataset, judged: Sequence[JudgedScene]) -> int:
    """Writes a sheet of the scenes in which judge and label differ; returns how many there are."""
    wrong = [scene for scene in judged if not scene.is_right][:_MAX_PICTURES]
    if not wrong:
        return 0
    pictures, captions = [], []
    for item in wrong:
        scene: Scene = dataset.scene(item.name)
        pictures.append(render_scene(scene.objects, width=320, height=260))
        answer = item.judgement.relation
        captions.append(f'{item.label.name} / {"none" if answer is None else answer.name}')
    write_image(path, contact_sheet(pictures, captions))
    return len(wrong)


def main(arguments: Sequence[str] | None = None) -> int:
    """Prints the accuracy; returns the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').partition('\n')[0])
    parser.add_argument('data', type=Path, help='a generated dataset, with meshes')
    parser.add_argument('--scenes', type=int, help='judge only that many')
    parser.add_argument('--pictures', type=Path, help='sheet of the disagreements')
    parser.add_argument('--json', type=Path)
    options = parser.parse_args(arguments)
    dataset = load_dataset(options.data)
    start = time.perf_counter()
    judged = judge_dataset(dataset, num_scenes=options.scenes)
    seconds = (time.perf_counter() - start) / len(judged)
    report = {'version': __version__, 'data': options.data.name, **summarize(judged)}
    report['seconds_a_scene'] = round(seconds, 3)
    for name, numbers in report['accuracy'].items():
        low, high = (100.0 * bound for bound in numbers['wilson_95'])
        print(
            f'{name}: {numbers["right"]} of {numbers["scenes"]}, '
            f'{100.0 * numbers["accuracy"]:.2f} % (95 %: {low:.1f} to {high:.1f})'
        )
    for item in judged:
        if not item.is_right:
            print(f'{item.name}: {item.label.name}, the judge: {_words(item.judgement)}')
    print(f'{seconds:.2f} s a scene')
    if options.pictures is not None:
        draw_disagreements(options.pictures, dataset, judged)
    if options.json is not None:
        with atomic_write(options.json) as temporary:
            temporary.write_text(json.dumps(report, indent=2) + '\n')
    return 0


def _words(judgement: Judgement) -> str:
    measures = judgement.measures
    name = 'none' if judgement.relation is None else judgement.relation.name
    return (
        f'{name}, {judgement.reason} (tilt {np.degrees(measures.tilt_rad):.0f}, '
        f'enclosed {measures.enclosed:.2f}, sunk {measures.sunk:.2f}, {measures.footing})'
    )


if __name__ == '__main__':
    sys.exit(main())
