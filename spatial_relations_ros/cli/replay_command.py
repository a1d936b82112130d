"""``relations replay``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape

from spatial_relations_ros.cli.bag_publishing import publish_bag
from spatial_relations_ros.cli.error_reports import FAILED
from spatial_relations_ros.cli.imitation_files import REPORT_SUFFIXES, check_suffix
from spatial_relations_ros.cli.options import SeedOption, WeightsOption
from spatial_relations_ros.cli.output import (
    JsonOption,
    Output,
    check_file,
    json_text,
    progress_bar,
)
from spatial_relations_ros.cli.recording import RerunOption, check_recording, record_reports
from spatial_relations_ros.cli.replay_output import show_report, show_timing, write_page

if TYPE_CHECKING:
    from spatial_relations_ros.evaluation.bag_reader import BagTopics
    from spatial_relations_ros.evaluation.executors import Executor
    from spatial_relations_ros.evaluation.replay import ReplayReport
    from spatial_relations_ros.evaluation.replay_jobs import FailedReplay, OnProgress, ReplayJob


def replay(
    bags: Annotated[
        list[Path], typer.Argument(metavar='BAG...', help='Each a rosbag2: mcap or sqlite3.')
    ],
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
    times: Annotated[
        list[float] | None,
        typer.Option(
            '--at', metavar='SECONDS', min=0.0,
            help='Imitate this long after the first cloud; repeat for more.',
        ),
    ] = None,
    demonstrations: Annotated[
        bool,
        typer.Option(
            '--demonstrations', help='Imitate each relation that holds still for a second, once.'
        ),
    ] = False,
    world_frame: Annotated[str, typer.Option('--world-frame', help='Frame of results.')] = 'world',
    points_topic: Annotated[
        str | None,
        typer.Option('--points-topic', help='Clouds; found by type.', show_default=False),
    ] = None,
    tracked_topics: Annotated[
        list[str] | None,
        typer.Option('--tracked-topic', help='Tracked poses; with --points-topic.'),
    ] = None,
    pose_topics: Annotated[
        list[str] | None,
        typer.Option(
            '--pose-topic',
            help='PoseStamped of one object, as "/topic/id" or "id=/topic"; with --points-topic.',
        ),
    ] = None,
    weights: WeightsOption = None,
    seed: SeedOption = 0,
    jobs: Annotated[
        int, typer.Option('--jobs', min=1, help='Bags at once, each in a process of its own.')
    ] = 1,
    cluster: Annotated[
        str | None,
        typer.Option(
            '--cluster', metavar='ADDRESS', show_default=False,
            help='Work on the Ray cluster there: auto, host:port or local.',
        ),
    ] = None,
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
            help='Write a page to look at: curves, pictures, each imitation in 3-D.',
        ),
    ] = None,
    publish: Annotated[
        bool,
        typer.Option('--publish', help='Publish the bag into the ROS graph instead; needs ROS.'),
    ] = False,
    rate: Annotated[
        float, typer.Option('--rate', min=0.01, help='With --publish: times faster.')
    ] = 1.0,
    loop: Annotated[
        bool, typer.Option('--loop', help='With --publish: start again at the end.')
    ] = False,
    clock: Annotated[
        bool, typer.Option('--clock', help='With --publish: the recorded time on /clock.')
    ] = False,
    recording: RerunOption = None,
    json_path: JsonOption = None,
) -> None:  # fmt: skip
    """Replay bags through perception, and imitate what they show.

    The files but that of --timing are byte-identical for the same input.
    Exit code 1 when no imitation succeeded, or one of several bags could not be replayed.
    """
    if publish:
        raise typer.Exit(publish_bag(bags, rate=rate, loop=loop, clock=clock))
    from spatial_relations_ros.evaluation.replay import ReplayOptions, ReplayReport
    from spatial_relations_ros.evaluation.replay_jobs import ReplayJob
    from spatial_relations_ros.evaluation.replay_report import (
        report_content,
        report_csv,
        reports_content,
    )
    from spatial_relations_ros.imitation import ImitationOptions
    from spatial_relations_ros.learning import load_metric

    output = Output(json_path)
    check_file(csv, '--csv')
    check_file(timing, '--timing')
    check_suffix(page, '--report', REPORT_SUFFIXES)
    check_recording(recording)
    metric = None if reference is None else load_metric(weights)
    options = ReplayOptions(
        reference_ids=reference,
        test_ids=test,
        every=every,
        frame_idxs=tuple(frames or ()),
        at_sec=tuple(times or ()),
        demonstrations=demonstrations,
        imitation=ImitationOptions(seed=seed),
    )
    topics = _topics(points_topic, tracked_topics or [], pose_topics or [])
    todo = [ReplayJob(bag, options, topics, models, world_frame, weights) for bag in bags]
    replays = _run(todo, _executor(jobs, cluster))
    reports = [replay for replay in replays if isinstance(replay, ReplayReport)]
    _show(output, replays)
    output.write_json(report_content(reports[0]) if len(bags) == 1 else reports_content(replays))
    _write(csv, report_csv(*reports))
    if timing is not None:
        _write(timing, json_text(show_timing(output, reports)))
    if page is not None and reports:
        write_page(output, page, reports, metric)
    if recording is not None and reports:
        record_reports(output, recording, reports, metric)
    if len(reports) < len(bags) or (reference is not None and not _has_success(reports)):
        raise typer.Exit(FAILED)


def _topics(
    points: str | None, tracked_objects: Sequence[str], pose_entries: Sequence[str]
) -> BagTopics | None:
    from spatial_relations_ros.evaluation.bag_reader import BagTopics
    from spatial_relations_ros.perception.pose_topics import pose_topics

    has_poses = bool(tracked_objects or pose_entries)
    if points is None and not has_poses:
        return None
    if points is None or not has_poses:
        raise typer.BadParameter(
            '--points-topic goes together with --tracked-topic or --pose-topic'
        )
    return BagTopics(
        points, tuple(tracked_objects), pose_topics(pose_entries, name='--pose-topic')
    )


def _executor(num_jobs: int, cluster: str | None) -> Executor:
    from spatial_relations_ros.evaluation.executors import (
        ProcessExecutor,
        RayExecutor,
        SerialExecutor,
    )

    if cluster is not None:
        if num_jobs > 1:
            raise typer.BadParameter('--jobs and --cluster do not go together')
        return RayExecutor(cluster)
    return SerialExecutor() if num_jobs == 1 else ProcessExecutor(num_jobs)


def _run(todo: Sequence[ReplayJob], executor: Executor) -> list[ReplayReport | FailedReplay]:
    """Replays all; a single bag that cannot be replayed raises its error."""
    from spatial_relations_ros.evaluation.executors import SerialExecutor
    from spatial_relations_ros.evaluation.replay_jobs import FailedReplay, run_jobs

    replays: list[ReplayReport | FailedReplay] = []
    is_here = isinstance(executor, SerialExecutor)
    with _progress(len(todo), is_here=is_here) as (on_frame, on_bag):
        for replayed in run_jobs(todo, executor, on_frame if is_here else None):
            replays.append(replayed)
            on_bag(len(replays), len(todo))
    if len(todo) == 1 and isinstance(replays[0], FailedReplay):
        raise replays[0].error
    return replays


@contextmanager
def _progress(num_bags: int, *, is_here: bool) -> Iterator[tuple[OnProgress, OnProgress]]:
    """A bar of frames where they can be counted, with the number of bags behind it."""
    with progress_bar('frames' if is_here else 'bags') as advance:
        done = 0

        def on_frame(frame: int, total: int) -> None:
            advance(frame, total, f'bag {done + 1} of {num_bags}' if num_bags > 1 else '')

        def on_bag(bag: int, total: int) -> None:
            nonlocal done
            done = bag
            if not is_here:
                advance(bag, total)

        yield on_frame, on_bag


def _show(output: Output, replays: Sequence[ReplayReport | FailedReplay]) -> None:
    from spatial_relations_ros.evaluation.replay import ReplayReport

    for replayed in replays:
        if isinstance(replayed, ReplayReport):
            show_report(output, replayed)
        else:
            output.say(f'[red]{escape(replayed.bag_name)}: {escape(str(replayed.error))}[/]')


def _has_success(reports: Sequence[ReplayReport]) -> bool:
    return any(
        frame.imitation is not None and frame.imitation.success
        for report in reports
        for frame in report.frames
    )


def _write(path: Path | None, text: str) -> None:
    if path is None:
        return
    from spatial_relations_ros.core import atomic_write

    with atomic_write(path) as temporary:
        temporary.write_text(text)
