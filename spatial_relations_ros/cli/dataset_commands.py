"""``relations generate``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from spatial_relations_ros.cli.options import SeedOption
from spatial_relations_ros.cli.output import JsonOption, Output, progress_bar


def generate(
    folder: Annotated[Path, typer.Argument(metavar='DIR', help='Folder to write.')],
    scenes: Annotated[int, typer.Option('--scenes', min=1, help='Scenes in all.')] = 546,
    objects: Annotated[int, typer.Option('--objects', min=1, help='Objects in all.')] = 60,
    points: Annotated[int, typer.Option('--points', min=4, help='Points an object.')] = 8192,
    seed: SeedOption = 0,
    json_path: JsonOption = None,
) -> None:
    """Generate a synthetic dataset in the paper's folder format.

    The same numbers and seed give the same bytes.
    """
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
        )
    dataset = load_dataset(folder)
    counts = {
        relation.name.lower(): sum(scene.label == relation for scene in dataset.scenes)
        for relation in Relation
    }
    output.say(
        f'[bold]{len(dataset.scenes)}[/] scenes of {len(dataset.clouds)} objects in {folder}'
    )
    output.table(
        ('relation', 'scenes'),
        [(relation.description, counts[relation.name.lower()]) for relation in Relation],
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
        }
    )
