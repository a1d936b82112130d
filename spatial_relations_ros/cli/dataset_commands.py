"""``relations generate``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from spatial_relations_ros.cli.options import SeedOption
from spatial_relations_ros.cli.output import JsonOption, Output, check_folder, progress_bar


def generate(
    folder: Annotated[Path, typer.Argument(metavar='DIR', help='Folder to write.')],
    scenes: Annotated[int, typer.Option('--scenes', min=1, help='Scenes in all.')] = 546,
    objects: Annotated[int, typer.Option('--objects', min=1, help='Objects in all.')] = 60,
    points: Annotated[int, typer.Option('--points', min=4, help='Points an object.')] = 8192,
    jobs: Annotated[int, typer.Option('--jobs', min=1, help='Processes that draw scenes.')] = 1,
    physics: Annotated[
        bool, typer.Option('--physics', help='Refuse scenes that do not stay put in MuJoCo.')
    ] = False,
    seed: SeedOption = 0,
    json_path: JsonOption = None,
) -> None:
    """Generate a synthetic dataset in the paper's folder format.

    The same numbers and seed give the same bytes, with any number of processes.
    """
    check_folder(folder, 'DIR')
    from spatial_relations_ros.core import Relation
    from spatial_relations_ros.datasets.freiburg import load_dataset
    from spatial_relations_ros.datasets.generator import generate_dataset

    output = Output(json_path)
    with progress_bar('scenes') as advance:
        generate_dataset(
            folder,
            num_scenes=scenes,
            num_objects=objects,
            seed=seed,
            num_points=points,
            on_progress=advance,
            num_jobs=jobs,
            physics=physics,
        )
    dataset = load_dataset(folder)
    rejected = json.loads((folder / 'dataset.json').read_text(encoding='utf-8'))['rejected']
    counts = {
        relation.name.lower(): sum(scene.label == relation for scene in dataset.scenes)
        for relation in Relation
    }
    output.say(
        f'[bold]{len(dataset.scenes)}[/] scenes of {len(dataset.clouds)} objects in '
        f'{escape(str(folder))}'
    )
    output.table(
        ('relation', 'scenes', 'refused candidates'),
        [
            (
                relation.description,
                counts[relation.name.lower()],
                _listed(rejected[relation.name.lower()]),
            )
            for relation in Relation
        ],
    )
    output.write_json(
        {
            'folder': str(folder),
            'seed': seed,
            'num_scenes': len(dataset.scenes),
            'num_objects': len(dataset.clouds),
            'num_splits': len(dataset.splits),
            'num_object_splits': len(dataset.object_splits),
            'scenes_of_relation': counts,
            'rejected': rejected,
        }
    )


def _listed(reasons: dict[str, int]) -> str:
    """Reasons with their counts, as in dataset.json the most frequent first."""
    return ', '.join(f'{count} {reason}' for reason, count in reasons.items()) or 'none'
