"""``relations replay``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape

from spatial_relations_ros.cli.error_reports import FAILED
from spatial_relations_ros.cli.imitation_files import (
    REPORT_SUFFIXES,
    check_suffix,
    shown_imitation,
)
from spatial_relations_ros.cli.options import SeedOption, WeightsOption
from spatial_relations_ros.cli.output import JsonOption, Output, json_text, progress_bar

if TYPE_CHECKING:
    from spatial_relations_ros.evaluation.bag_reader import BagTopics
    from spatial_relations_ros.evaluation.replay import ReplayedFrame, ReplayOptions, ReplayReport
    from spatial_relations_ros.learning import RelationMetric


def replay(
    bag: Annotated[Path, typer.Argument(metavar='BAG', help='A rosbag2: mcap or sqlite3.')],
    reference: Annotated[
        tuple[str, str] | None,
        typer.Option(
            '--reference', metavar='BASE RELATIVE', show_default=False,
            help='Object ids of the demonstration; without them perception alone is replayed.',
        ),
    ] = None,
    test: Annotated[
        tuple[str, str] | None,
        typer.Option(
            '--test', metavar='BASE RELATIVE', help='Object ids to place.', show_default=False
        ),
    ] = None,
    models: Annotated[
        Path | None,
        typer.Option(
            '--models', metavar='DIR', show_default=False,
            help='Object models by id; without them objects are taken from the clouds.',
        ),
    ] = None,
    every: Annotated[
        int, typer.Option('--every', min=1, help='Imitate in every n-th frame that shows all.')
    ] = 5,
    frames: Annotated[
        list[int] | None,
        typer.Option('--frame', min=0, help='Imitate in this frame; repeat for more.'),
    ] = None,
    world_frame: Annotated[str, typer.Option('--world-frame', help='Frame of results.')] = 'world',
    points_topic: Annotated[
        str | None,
        typer.Option('--points-topic', help='Clouds; found by type.', show_default=False),
    ] = None,
    tracked_topics: Annotated[
        list[str] | None,
        typer.Option('--tracked-topic', help='Tracked poses; with --points-topic.'),
    ] = None,
    weights: WeightsOption = None,
    seed: SeedOption = 0,
    timing: Annotated[
        Path | None,
        typer.Option(
            '--timing', metavar='OUT', show_default=False, help='Write wall times as JSON.'
        ),
    ] = None,
    csv: Annotated[
        Path | None,
        typer.Option('--csv', metavar='OUT', show_default=False, help='Write a row a frame.'),
    ] = None,
    page: Annotated[
        Path | None,
        typer.Option(
            '--report', metavar='HTML', show_default=False,
            help='Write a page to look at: each imitation in 3-D.',
        ),
    ] = None,
    json_path: JsonOption = None,
) -> None:  # fmt: skip
    """Replay a bag through perception, and imitate what it shows.

    The JSON and CSV files are byte-identical for the same input; wall times go to --timing.
    Exit code 1 when no imitation succeeded.
    """
    from spatial_relations_ros.evaluation.replay import ReplayOptions
    from spatial_relations_ros.evaluation.replay_report import report_content, report_csv
    from spatial_relations_ros.imitation import ImitationOptions

    output = Output(json_path)
    check_suffix(page, '--report', REPORT_SUFFIXES)
    from spatial_relations_ros.learning import load_metric

    metric = None if reference is None else load_metric(weights)
    options = ReplayOptions(
        reference_ids=reference,
        test_ids=test,
        every=every,
        frame_idxs=tuple(frames or ()),
        imitation=ImitationOptions(seed=seed),
    )
    topics = _topics(points_topic, tracked_topics or [])
    report = _run(bag, options, topics, models, world_frame, metric)
    _show(output, report)
    output.write_json(report_content(report))
    _write(csv, report_csv(report))
    _write(timing, json_text(_timing(output, report)))
    if page is not None:
        _write_page(output, page, report, metric, options)
    wanted = reference is not None
    if wanted and not any(f.imitation is not None and f.imitation.success for f in report.frames):
        raise typer.Exit(FAILED)


def _topics(points_topic: str | None, tracked_topics: list[str]) -> BagTopics | None:
    from spatial_relations_ros.evaluation.bag_reader import BagTopics

    if points_topic is None and not tracked_topics:
        return None
    if points_topic is None or not tracked_topics:
        raise typer.BadParameter('--points-topic and --tracked-topic go together')
    return BagTopics(points_topic, tuple(tracked_topics))


def _run(
    bag: Path,
    options: ReplayOptions,
    topics: BagTopics | None,
    models: Path | None,
    world_frame: str,
    metric: RelationMetric | None,
) -> ReplayReport:
    from spatial_relations_ros.evaluation.bag_reader import BagReader
    from spatial_relations_ros.evaluation.replay import replay_bag
    from spatial_relations_ros.pipeline import LibraryModels, PerceptionConfig, Pipeline

    pipeline = Pipeline(
        PerceptionConfig(world_frame=world_frame),
        None if models is None else LibraryModels(models),
    )
    with BagReader(bag, topics) as reader:
        num_clouds = reader.contents[reader.topics().points][1]
    with progress_bar('frames') as advance:

        def on_frame(frame: ReplayedFrame) -> None:
            advance(frame.frame_idx + 1, num_clouds)

        return replay_bag(bag, pipeline, metric, options, topics=topics, on_frame=on_frame)


def _write_page(
    output: Output,
    path: Path,
    report: ReplayReport,
    metric: RelationMetric | None,
    options: ReplayOptions,
) -> None:
    """A page of all imitations whose four objects the frame shows."""
    from spatial_relations_ros.visualization import write_report

    shown = []
    for frame in report.frames:
        if frame.imitation is None or metric is None:
            continue
        ids = (*(options.reference_ids or ()), *(options.test_ids or ()))
        if not set(ids) <= set(frame.result.objects):
            continue
        reference, test = frame.result.scene(*ids[:2]), frame.result.scene(*ids[2:])
        shown.append(
            shown_imitation(
                metric, reference, test, frame.imitation,
                table_height=frame.result.table_height, title=f'frame {frame.frame_idx}',
            )
        )  # fmt: skip
    if not shown:
        output.say('no imitation was made: there is nothing to report')
        return
    write_report(path, shown, title=f'{ids[3]} to {ids[2]} as {ids[1]} to {ids[0]}')
    output.say(f'report: [bold]{escape(str(path))}[/]')


def _show(output: Output, report: ReplayReport) -> None:
    from spatial_relations_ros.evaluation.replay_report import summary

    rows: list[tuple[object, ...]] = []
    for frame in report.frames:
        if frame.imitation is None:
            continue
        best = frame.imitation.answers[0] if frame.imitation.answers else None
        rows.append(
            (
                frame.frame_idx,
                float(frame.imitation.initial_distance),
                '' if best is None else f'{best.distance:.4f}',
                '' if best is None else ('yes' if best.feasible else 'no'),
                frame.imitation.message,
            )
        )
    if rows:
        output.table(('frame', 'distance before', 'after', 'feasible', 'outcome'), rows)
    counts = summary(report)
    output.say(
        f'{counts["num_frames"]} frames, {counts["num_problems"]} unusable, '
        f'{counts["num_dropped"]} messages dropped, {counts["num_successes"]} of '
        f'{counts["num_imitations"]} imitations succeeded'
    )
    for reason in _reasons(report):
        output.say(f'  {reason}')


def _reasons(report: ReplayReport) -> list[str]:
    """Why frames and messages could not be used, each reason once with its count."""
    counts: dict[str, int] = {}
    for frame in report.frames:
        for reason in filter(None, [frame.result.problem or frame.reason]):
            counts[reason] = counts.get(reason, 0) + 1
    for item in report.dropped:
        reason = f'{item.topic}: {item.reason}'
        counts[reason] = counts.get(reason, 0) + 1
    ranked = sorted(counts.items(), key=lambda entry: (-entry[1], entry[0]))
    return [f'{count} x {reason}' for reason, count in ranked[:10]]


def _timing(output: Output, report: ReplayReport) -> dict[str, Any]:
    from spatial_relations_ros.evaluation.replay_report import timing_content

    timing = timing_content(report)
    output.table(
        ('step', 'runs', 'median ms', 'p90 ms'),
        [
            (step, entry['num'], 1e3 * entry['median'], 1e3 * entry['p90'])
            for step, entry in timing.items()
            if entry['num']
        ],
    )
    return timing


def _write(path: Path | None, text: str) -> None:
    if path is None:
        return
    from spatial_relations_ros.core import atomic_write

    with atomic_write(path) as temporary:
        temporary.write_text(text)
