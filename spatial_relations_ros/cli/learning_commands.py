"""``relations train``."""

from __future__ import annotations

import dataclasses
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape

from spatial_relations_ros.cli.options import SeedOption
from spatial_relations_ros.cli.output import (
    JsonOption,
    Output,
    check_file,
    check_folder,
    progress_bar,
)

if TYPE_CHECKING:
    from spatial_relations_ros.learning import ModelCard
    from spatial_relations_ros.learning.trainer import TrainingProgress


class Precision(StrEnum):
    """Of the convolutions in training."""

    FLOAT32 = 'float32'
    BFLOAT16 = 'bfloat16'


DatasetArgument = Annotated[Path, typer.Argument(metavar='DIR', help='Dataset folder.')]


def train(
    folder: DatasetArgument,
    out: Annotated[Path, typer.Option('--out', metavar='FILE', help='Weights (.safetensors).')],
    config: Annotated[
        str,
        typer.Option(
            '--config', help='One of default, multi_similarity, jund2018, paper, released.'
        ),
    ] = 'default',
    steps: Annotated[
        int | None,
        typer.Option('--steps', min=1, help='Instead of those configured.', show_default=False),
    ] = None,
    precision: Annotated[
        Precision | None,
        typer.Option(
            '--precision', show_default=False,
            help='Of the convolutions, instead of the one configured (float32); bfloat16 is mixed '
            'precision, for GPUs.',
        ),
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            '--set', metavar='NAME=VALUE', show_default=False,
            help="Another of the configuration's settings, as in partial_share=0; repeatable.",
        ),
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
    device: Annotated[
        str, typer.Option('--device', help='auto (a GPU where there is one), cpu or cuda.')
    ] = 'auto',
    seed: SeedOption = 0,
    json_path: JsonOption = None,
) -> None:  # fmt: skip
    """Train a metric on a dataset; weights and their card are written.

    Retrieval is measured on scenes whose objects were not trained on. For several GPUs or
    machines: torchrun --nproc-per-node N --no-python relations train ...
    """
    if out.suffix != '.safetensors':
        raise typer.BadParameter(f'--out {out}: weights are written as .safetensors')
    check_file(out, '--out')
    check_folder(run_dir, '--run-dir')
    from spatial_relations_ros.evaluation.training import train_metric
    from spatial_relations_ros.learning.training_config import parse_settings

    changes = parse_settings(settings or [])
    options = {'steps': steps, 'precision': None if precision is None else precision.value}
    for name, value in options.items():
        if value is not None and name in changes:
            raise typer.BadParameter(f'--{name} and --set {name}= say the same; give one')
        if value is not None:
            changes[name] = value
    output = Output(json_path)
    with progress_bar('steps') as advance:

        def on_progress(progress: TrainingProgress) -> None:
            advance(progress.step, progress.steps, f'loss {progress.loss:.4f}')

        card = train_metric(
            folder,
            out,
            config_name=config,
            seed=seed,
            changes=changes,
            held_out_dir=held_out,
            run_dir=run_dir,
            device=device,
            on_progress=on_progress,
        )
    if card is None:
        return
    output.say(
        f'weights in [bold]{escape(str(out))}[/], {card.steps} steps, sha256 {card.sha256[:12]}'
    )
    output.table(
        (f'retrieval on {_measured_on(card)}', ''),
        [
            (name, value)
            for name, value in card.retrieval.items()
            if isinstance(value, int | float)
        ],
    )
    output.say(
        'Confidence in answers of an imitation is not calibrated for these weights: '
        'docs/results.md#confidence-of-answers.'
    )
    output.write_json({'weights': str(out), 'card': dataclasses.asdict(card)})


def _measured_on(card: ModelCard) -> str:
    """What the retrieval of a card was measured on."""
    split = card.retrieval.get('split')
    if split is None:
        return 'the other dataset'
    kind = 'objects' if split.startswith('object') else 'scenes of the same objects'
    return f'held-out {kind} ({split})'
