"""``relations generalize``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape

from spatial_relations_ros.cli.error_reports import FAILED
from spatial_relations_ros.cli.imitation_files import REPORT_SUFFIXES, check_suffix
from spatial_relations_ros.cli.options import SeedOption, WeightsOption
from spatial_relations_ros.cli.output import (
    JsonOption,
    Output,
    check_file,
    check_folder,
    progress_bar,
)

if TYPE_CHECKING:
    from spatial_relations_ros.evaluation.generalization.cases import Case, Experiment
    from spatial_relations_ros.evaluation.generalization.outcome import Outcome
    from spatial_relations_ros.evaluation.generalization.running import Job, Runner


def generalize(
    folder: Annotated[
        Path, typer.Argument(metavar='DIR', help='Dataset folder with demonstrations.')
    ],
    known: Annotated[
        bool, typer.Option('--known/--no-known', help="Imitate with each other's objects.")
    ] = True,
    unknown: Annotated[
        Path | None,
        typer.Option(
            '--unknown', metavar='DIR', show_default=False,
            help='Folder of object models that no scene has: imitate with all pairs of them.',
        ),
    ] = None,
    random_pairs: Annotated[
        int, typer.Option('--random', min=0, help='So many random pairs of generated objects.')
    ] = 0,
    objects: Annotated[
        int, typer.Option('--random-objects', min=2, help='Objects that these are drawn from.')
    ] = 194,
    max_cases: Annotated[
        int | None,
        typer.Option(
            '--cases', min=1, show_default=False,
            help='At most so many cases of each experiment, evenly over all.',
        ),
    ] = None,
    variants: Annotated[
        str,
        typer.Option(
            '--variants', metavar='NAMES',
            help='Ways of imitating, with commas between: ours, paper, features, no-gradient, '
            'no-proposals, no-physics, one-start, soft.',
        ),
    ] = 'ours',
    variant_cases: Annotated[
        int | None,
        typer.Option(
            '--variant-cases', min=1, show_default=False,
            help='All variants but the first run on so many cases of each experiment.',
        ),
    ] = None,
    weights: WeightsOption = None,
    paper_weights: Annotated[
        Path | None,
        typer.Option(
            '--paper-weights', metavar='FILE', show_default=False,
            help="Weights of the paper's network for the variant paper; ours by default.",
        ),
    ] = None,
    physics: Annotated[
        bool,
        typer.Option('--physics/--no-physics', help='Let results go in MuJoCo for a second.'),
    ] = True,
    jobs: Annotated[int, typer.Option('--jobs', min=1, help='Processes, one thread each.')] = 1,
    markdown: Annotated[
        Path | None,
        typer.Option(
            '--markdown', metavar='OUT', show_default=False, help='Write tables as Markdown.'
        ),
    ] = None,
    pictures: Annotated[
        Path | None,
        typer.Option(
            '--pictures', metavar='DIR', show_default=False,
            help='Write sheets of all cases: demonstration, before, after; failures first.',
        ),
    ] = None,
    page: Annotated[
        Path | None,
        typer.Option(
            '--report', metavar='HTML', show_default=False,
            help='Write a page to look at: up to forty cases in 3-D, failures first.',
        ),
    ] = None,
    seed: SeedOption = 0,
    json_path: JsonOption = None,
) -> None:  # fmt: skip
    """Measure how relations generalise to other objects, judged by geometry and simulation.

    The paper's two experiments (known and unknown objects) and random pairs. An imitation is
    right when the relation is that of the demonstration, in class and continuous part, and the
    result is physically possible. Exit code 1 when nothing was right.
    """
    from spatial_relations_ros.cli.scene_sources import read_dataset
    from spatial_relations_ros.evaluation.generalization.experiments import Plan, make_experiments
    from spatial_relations_ros.evaluation.generalization.feasibility import require_simulation
    from spatial_relations_ros.evaluation.generalization.running import (
        Runner,
        Settings,
        jobs_of,
    )
    from spatial_relations_ros.evaluation.generalization.variants import Weights, check_variants

    output = Output(json_path)
    check_file(markdown, '--markdown')
    check_folder(pictures, '--pictures')
    check_suffix(page, '--report', REPORT_SUFFIXES)
    names = check_variants([name.strip() for name in variants.split(',') if name.strip()])
    if physics:
        require_simulation()
    dataset = read_dataset(folder)
    plan = Plan(known, unknown, random_pairs, objects, max_cases, seed, simulate=physics)
    with progress_bar('cases drawn') as advance:
        experiments = make_experiments(dataset, plan, on_progress=advance)
    cases = [case for experiment in experiments for case in experiment.cases]
    todo = jobs_of(cases, names, variant_cases)
    settings = Settings(Weights(weights, paper_weights), seed=seed, simulate=physics)
    with Runner(cases, settings, num_jobs=jobs).started() as runner:
        with progress_bar('imitations') as advance:
            outcomes = runner.run(todo, advance)
        paths = _draw(pictures, runner, todo, outcomes) if pictures is not None else []
    if page is not None:
        _write_page(output, page, cases, todo, outcomes)
    content = _report(experiments, outcomes)
    _say(output, content, paper_weights)
    if markdown is not None:
        from spatial_relations_ros.core import atomic_write
        from spatial_relations_ros.evaluation.generalization import tables

        with atomic_write(markdown) as temporary:
            temporary.write_text(tables.markdown(content['results']))
    from spatial_relations_ros.cli.provenance import provenance
    from spatial_relations_ros.evaluation.held_out import describe_data
    from spatial_relations_ros.learning import load_metric

    output.write_json(
        {
            **content,
            'model_hash': load_metric(weights).model_hash,
            'paper_model_hash': load_metric(paper_weights or weights).model_hash,
            'simulated': physics,
            'jobs': jobs,
            'pictures': [str(path) for path in paths],
            'data': describe_data(folder, dataset),
            'seed': seed,
            'provenance': provenance(),
        }
    )
    if not any(outcome.is_right for outcome in outcomes if outcome.variant == names[0]):
        raise typer.Exit(FAILED)


def _write_page(
    output: Output, path: Path, cases: Sequence[Case], jobs: Sequence[Job],
    outcomes: Sequence[Outcome],
) -> None:  # fmt: skip
    from spatial_relations_ros.evaluation.generalization.page import shown_outcomes
    from spatial_relations_ros.visualization import write_report

    places = [(idx, outcome) for (_, idx), outcome in zip(jobs, outcomes, strict=True)]
    write_report(path, shown_outcomes(cases, places), title='Generalisation')
    output.say(f'report: [bold]{escape(str(path))}[/]')


def _report(experiments: Sequence[Experiment], outcomes: Sequence[Outcome]) -> dict[str, Any]:
    from spatial_relations_ros.evaluation.generalization.summary import summarize

    return {
        'experiments': [experiment.entry() for experiment in experiments],
        'results': summarize(outcomes),
        'cases': [outcome.entry() for outcome in outcomes],
    }


def _say(output: Output, content: dict[str, Any], paper_weights: Path | None) -> None:
    from spatial_relations_ros.evaluation.generalization import tables

    for experiment in content['experiments']:
        left_out = ', '.join(
            f'{count} since {reason}' for reason, count in experiment['left_out'].items()
        )
        output.say(
            f'[bold]{experiment["name"]}[/]: {experiment["description"]}; '
            f'{experiment["cases"]} cases' + (f'; left out: {left_out}' if left_out else '')
        )
    results = content['results']
    output.table(tables.RESULT_COLUMNS, tables.result_rows(results))
    output.table(tables.CLAIM_COLUMNS, tables.claim_rows(results))
    for result in results:
        title = f'{result["experiment"]}, {result["variant"]}'
        if result['variant'] == results[0]['variant']:
            output.table(tables.RELATION_COLUMNS, tables.relation_rows(result), title=title)
        output.say(f'{title}: failures: {tables.failure_text(result)}')
    if any(result['variant'] == 'paper' for result in results):
        output.say(
            "paper: its settings with our network's weights; --paper-weights takes its own"
            if paper_weights is None
            else f'paper: its settings with the weights {paper_weights}'
        )


def _draw(
    folder: Path, runner: Runner, jobs: Sequence[Job], outcomes: Sequence[Outcome]
) -> list[Path]:
    from spatial_relations_ros.evaluation.generalization.views import write_sheets

    with progress_bar('cases drawn') as advance:
        views = runner.draw(
            [(idx, outcome) for (_, idx), outcome in zip(jobs, outcomes, strict=True)], advance
        )
    return write_sheets(folder, views)
