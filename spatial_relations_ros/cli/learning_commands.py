"""``relations train`` and ``relations retrieve``."""

from __future__ import annotations

import dataclasses
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from spatial_relations_ros.cli.options import SeedOption, WeightsOption
from spatial_relations_ros.cli.output import JsonOption, Output, progress_bar

if TYPE_CHECKING:
    from spatial_relations_ros.learning.trainer import TrainingProgress

DatasetArgument = Annotated[Path, typer.Argument(metavar='DIR', help='Dataset folder.')]


class Protocol(StrEnum):
    """Which splits retrieval runs over."""

    SCENE = 'scene'
    OBJECT = 'object'
    BOTH = 'both'


def train(
    folder: DatasetArgument,
    out: Annotated[Path, typer.Option('--out', metavar='FILE', help='Weights (.safetensors).')],
    config: Annotated[
        str, typer.Option('--config', help='Training configuration: default, jund2018, paper.')
    ] = 'default',
    steps: Annotated[
        int | None,
        typer.Option('--steps', min=1, help='Instead of those configured.', show_default=False),
    ] = None,
    held_out: Annotated[
        Path | None,
        typer.Option(
            '--held-out', metavar='DIR', show_default=False,
            help='Dataset of other objects to measure retrieval on.',
        ),
    ] = None,
    run_dir: Annotated[
        Path | None,
        typer.Option(
            '--run-dir', metavar='DIR', show_default=False,
            help='Folder of checkpoint and loss curve; a run found there goes on.',
        ),
    ] = None,
    seed: SeedOption = 0,
    json_path: JsonOption = None,
) -> None:  # fmt: skip
    """Train a metric on a dataset; weights and their card are written.

    Retrieval is measured on scenes whose objects were not trained on.
    """
    if out.suffix != '.safetensors':
        raise typer.BadParameter(f'--out {out}: weights are written as .safetensors')
    from spatial_relations_ros.evaluation.training import train_metric

    output = Output(json_path)
    with progress_bar('steps') as advance:

        def on_progress(progress: TrainingProgress) -> None:
            advance(progress.step, progress.steps, f'loss {progress.loss:.4f}')

        card = train_metric(
            folder,
            out,
            config_name=config,
            seed=seed,
            steps=steps,
            held_out_dir=held_out,
            run_dir=run_dir,
            on_progress=on_progress,
        )
    output.say(f'weights in [bold]{out}[/], {card.steps} steps, sha256 {card.sha256[:12]}')
    output.table(
        ('retrieval on held-out objects', ''),
        [
            (name, value)
            for name, value in card.retrieval.items()
            if isinstance(value, int | float)
        ],
    )
    output.write_json({'weights': str(out), 'card': dataclasses.asdict(card)})


def retrieve(
    folder: DatasetArgument,
    protocol: Annotated[
        Protocol, typer.Option('--protocol', help='Splits over scenes, over objects, or both.')
    ] = Protocol.BOTH,
    weights: WeightsOption = None,
    json_path: JsonOption = None,
) -> None:
    """Measure retrieval over the splits of a dataset: 3-of-5 and 5-of-5 nearest scenes.

    The weights are used as they are. Numbers mean something only on scenes that they were not
    trained with; object splits ask for scenes of objects that are not in the gallery.
    """
    from spatial_relations_ros.cli.scene_sources import read_dataset
    from spatial_relations_ros.evaluation.splits_report import retrieve as measure
    from spatial_relations_ros.evaluation.training import describe_data, report_entry
    from spatial_relations_ros.learning import load_metric

    output = Output(json_path)
    dataset = read_dataset(folder)
    metric = load_metric(weights)
    available = {'scene': dataset.splits, 'object': dataset.object_splits}
    names = [
        name
        for name in ('scene', 'object')
        if protocol.value == name or (protocol is Protocol.BOTH and available[name])
    ]
    entries: dict[str, Any] = {}
    for name in names or ['scene']:
        with progress_bar('scenes embedded') as advance:
            report = measure(metric, dataset, protocol=name, on_progress=advance)
        entries[name] = report_entry(report)
    output.table(
        ('splits', '3-of-5 %', '±', '5-of-5 %', '±', 'mean average precision'),
        [
            (
                entry['protocol'],
                100.0 * entry['three_of_five'],
                100.0 * entry['three_of_five_std'],
                100.0 * entry['five_of_five'],
                100.0 * entry['five_of_five_std'],
                entry['mean_average_precision'],
            )
            for entry in entries.values()
        ],
    )
    from spatial_relations_ros.cli.provenance import provenance

    output.say('baselines (hand-made features, LMNN) are not built yet')
    output.write_json(
        {
            'protocols': entries,
            'baselines': None,
            'data': describe_data(folder, dataset),
            'model_hash': metric.model_hash,
            'provenance': provenance(),
        }
    )
