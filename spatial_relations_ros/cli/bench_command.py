"""``relations bench`` and ``relations bench live``."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from spatial_relations_ros.cli.live_bench import run_live_bench
from spatial_relations_ros.cli.options import SeedOption, WeightsOption
from spatial_relations_ros.cli.output import JsonOption, Output, progress_bar

if TYPE_CHECKING:
    from spatial_relations_ros.evaluation.bench import Bench
    from spatial_relations_ros.evaluation.timings import Timing


class Step(StrEnum):
    """What can be timed."""

    EMBED = 'embed'
    BFLOAT16 = 'bfloat16'
    COMPILED = 'compiled'
    GRADIENT = 'gradient'
    IMITATE = 'imitate'
    TRAIN = 'train'
    PERCEPTION = 'perception'
    PAPER = 'paper'
    PAPER_GRADIENT = 'paper-gradient'
    READER = 'reader'
    STRUCTURED_READER = 'structured-reader'


bench_app = typer.Typer(name='bench', rich_markup_mode='markdown')


@bench_app.callback(invoke_without_command=True)
def bench(
    context: typer.Context,
    runs: Annotated[int, typer.Option('--runs', min=3, help='Of each step.')] = 20,
    steps: Annotated[
        list[Step] | None,
        typer.Option(
            '--step', show_default=False,
            help='Time this step only; repeat for more. All but those of the paper and the '
            "readers by default: those are for comparison, and the paper's setting takes minutes.",
        ),
    ] = None,
    config: Annotated[
        str, typer.Option('--config', help='Training configuration of the train step.')
    ] = 'default',
    bag: Annotated[
        Path | None,
        typer.Option('--bag', metavar='BAG', help='For perception.', show_default='bags/demo'),
    ] = None,
    models: Annotated[
        Path | None,
        typer.Option(
            '--models', metavar='DIR', help="The bag's object models.",
            show_default='bags/objects',
        ),
    ] = None,
    threads: Annotated[
        int | None,
        typer.Option(
            '--threads', min=1, show_default='as PyTorch finds',
            help='Threads that PyTorch computes with.',
        ),
    ] = None,
    weights: WeightsOption = None,
    seed: SeedOption = 0,
    json_path: JsonOption = None,
) -> None:  # fmt: skip
    """Time the steps on this machine: medians and spread after a warm-up."""
    if context.invoked_subcommand is not None:
        return
    from spatial_relations_ros.cli.provenance import provenance
    from spatial_relations_ros.evaluation.bench import Bench, use_threads
    from spatial_relations_ros.evaluation.timings import (
        peak_memory_mib,
        ratio_rows,
        timing_rows,
    )
    from spatial_relations_ros.learning import load_metric

    if threads is not None:
        use_threads(threads)
    output = Output(json_path)
    wanted = steps or [
        Step.EMBED, Step.GRADIENT, Step.IMITATE, Step.TRAIN, Step.PERCEPTION
    ]  # fmt: skip
    skipped: dict[str, str] = {}
    if Step.PERCEPTION in wanted and bag is None:
        bag, models = _shipped_demo(models)
        if bag is None:
            skipped['perception'] = 'there is no demo bag here; name one with --bag'
    metric = load_metric(weights)
    machine = Bench(metric, runs=runs, seed=seed)
    timings: list[Timing] = []
    for step in wanted:
        if step.value in skipped:
            continue
        with progress_bar(step.value) as advance:
            timings += _steps(machine, config, bag, models)[step](advance)
    rows = timing_rows(timings)
    output.table(
        ('step', 'runs', 'median ms', 'p90 ms', 'CPU ms'),
        [
            (
                row['step'],
                row['runs'],
                *(1e3 * float(row[name]) for name in ('median', 'p90', 'cpu_median')),
            )
            for row in rows
        ],
    )
    ratios = ratio_rows(timings)
    for row in ratios:
        output.say(f'{row["step"]}: {row["ratio"]:.1f} times faster than {row["than"]}')
    for name, reason in skipped.items():
        output.say(f'{name}: not measured, {reason}')
    conditions, memory = provenance(), peak_memory_mib()
    output.say(
        f'{conditions["num_threads"]} threads, {conditions["cpu"]}; at most {memory:.0f} MiB'
    )
    output.write_json(
        {
            'timings': rows,
            'ratios': ratios,
            'not_measured': skipped,
            'peak_memory_mib': memory,
            'seed': seed,
            'model_hash': metric.model_hash,
            'provenance': conditions,
        }
    )


class Stream(StrEnum):
    """Clouds of a Kinect2; as ``live_stream.FORMATS``, loaded without it."""

    SD = 'sd'
    SD32 = 'sd32'
    QHD = 'qhd'
    HD = 'hd'


@bench_app.command()
def live(
    streams: Annotated[
        list[Stream] | None,
        typer.Option(
            '--stream', show_default='sd and qhd',
            help='512 x 424 points of 16 (sd) or 32 bytes, 960 x 540 (qhd) or 1920 x 1080 (hd) of '
            '16; repeat for more.',
        ),
    ] = None,
    duration: Annotated[
        float, typer.Option('--duration', min=1.0, help='Seconds of each stream.')
    ] = 20.0,
    minutes: Annotated[
        float | None,
        typer.Option(
            '--minutes', min=0.1, show_default=False, help='The same in minutes, for a soak.'
        ),
    ] = None,
    rate: Annotated[
        float, typer.Option('--rate', min=0.1, max=200.0, help='Clouds a second.')
    ] = 30.0,
    reliable: Annotated[
        bool, typer.Option('--reliable', help='Deliver clouds reliably.')
    ] = False,
    without_models: Annotated[
        bool, typer.Option('--without-models', help='Objects are taken out of the clouds.')
    ] = False,
    all_pairs: Annotated[
        bool, typer.Option('--all-pairs', help='All 12 scenes of each cloud instead of two.')
    ] = False,
    markdown: Annotated[
        Path | None,
        typer.Option('--markdown', metavar='OUT', help='Write the table.', show_default=False),
    ] = None,
    json_path: JsonOption = None,
) -> None:  # fmt: skip
    """Measure perception_node over DDS: clouds received, latency, age, processor, memory.

    A publisher, the node and a subscriber run as processes of their own; needs ROS 2. The exit
    code is 1 when clouds or scenes were lost.
    """
    Output(json_path)  # refuses a file that cannot be written before the work
    flags = {'reliable': reliable, 'without-models': without_models, 'all-pairs': all_pairs}
    arguments = [f'--{name}' for name, is_set in flags.items() if is_set]
    for stream in streams or ():
        arguments += ['--stream', stream.value]
    seconds = duration if minutes is None else 60.0 * minutes
    arguments += ['--duration', str(seconds), '--rate', str(rate)]
    for name, path in (('json', json_path), ('markdown', markdown)):
        if path is not None:
            arguments += [f'--{name}', str(path)]
    code = run_live_bench(arguments)
    if code:
        raise typer.Exit(code)


def _steps(
    machine: Bench, config: str, bag: Path | None, models: Path | None
) -> dict[Step, Callable[[Any], list[Timing]]]:
    def perception(on_run: Any) -> Timing:
        from spatial_relations_ros.pipeline import LibraryModels

        assert bag is not None
        source = None if models is None else LibraryModels(models)
        return machine.perception(bag, source, on_run)

    single: dict[Step, Callable[[Any], Timing]] = {
        Step.EMBED: machine.embed,
        Step.GRADIENT: machine.pose_gradient,
        Step.PAPER: machine.imitate_as_paper,
        Step.PAPER_GRADIENT: machine.pose_gradient_of_paper,
        Step.TRAIN: lambda on_run: machine.train_step(config, on_run),
        Step.PERCEPTION: perception,
        Step.READER: machine.reader,
        Step.STRUCTURED_READER: machine.structured_reader,
    }

    def alone(step: Callable[[Any], Timing]) -> Callable[[Any], list[Timing]]:
        return lambda on_run: [step(on_run)]

    return {
        Step.IMITATE: machine.imitate,
        Step.BFLOAT16: machine.network_in_bfloat16,
        Step.COMPILED: machine.network_compiled,
        **{name: alone(step) for name, step in single.items()},
    }


def _shipped_demo(models: Path | None) -> tuple[Path | None, Path | None]:
    """The demo bag of a source checkout and its models."""
    from spatial_relations_ros.core import ConfigError, share_path

    try:
        return share_path('bags', 'demo'), models or share_path('bags', 'objects')
    except ConfigError:
        return None, models
