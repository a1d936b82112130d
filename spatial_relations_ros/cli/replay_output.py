"""What ``relations replay`` prints and writes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.markup import escape

from spatial_relations_ros.cli.imitation_files import shown_imitation
from spatial_relations_ros.cli.output import Output

if TYPE_CHECKING:
    from spatial_relations_ros.evaluation.replay import ReplayedFrame, ReplayReport
    from spatial_relations_ros.learning import RelationMetric
    from spatial_relations_ros.visualization import ReportSection, ShownImitation

NUM_REASONS = 10
# More pictures are of no use on a page, and would make it too large.
MAX_SHOWN = 24


def show_report(output: Output, report: ReplayReport) -> None:
    """Prints the imitations of a bag, and why frames and messages could not be used."""
    from spatial_relations_ros.evaluation.replay_report import summary

    rows = [_row(frame) for frame in report.frames if frame.imitation is not None]
    if rows:
        columns = ('frame', 'distance before', 'after', 'feasible', 'outcome')
        output.table(columns, rows, title=report.bag_name)
    counts = summary(report)
    plural = '' if counts['num_demonstrations'] == 1 else 's'
    output.say(
        f'{escape(report.bag_name)}: {counts["num_frames"]} frames, '
        f'{counts["num_problems"]} unusable, {counts["num_dropped"]} messages dropped, '
        f'{counts["num_demonstrations"]} demonstration{plural}, {counts["num_successes"]} of '
        f'{counts["num_imitations"]} imitations succeeded'
    )
    for request in report.requests:
        if request.frame_idx is None:
            output.say(f'  at {request.at_sec:g} s: no later frame shows all four objects')
    for reason, count in _reasons(report):
        output.say(f'  {count} x {escape(reason)}')


def _row(frame: ReplayedFrame) -> tuple[object, ...]:
    assert frame.imitation is not None
    best = frame.imitation.answers[0] if frame.imitation.answers else None
    return (
        frame.frame_idx,
        float(frame.imitation.initial_distance),
        '' if best is None else f'{best.distance:.4f}',
        '' if best is None else ('yes' if best.feasible else 'no'),
        frame.imitation.message,
    )


def _reasons(report: ReplayReport) -> list[tuple[str, int]]:
    """Why frames and messages could not be used, the most frequent first."""
    counts: Counter[str] = Counter()
    for frame in report.frames:
        counts.update(filter(None, [frame.problem or frame.reason]))
    counts.update(f'{item.topic}: {item.reason}' for item in report.dropped)
    return sorted(counts.items(), key=lambda entry: (-entry[1], entry[0]))[:NUM_REASONS]


def show_timing(output: Output, reports: Sequence[ReplayReport]) -> dict[str, Any]:
    """Prints how long the steps took, and gives it."""
    from spatial_relations_ros.evaluation.replay_report import timing_content

    timing = timing_content(*reports)
    output.table(
        ('step', 'runs', 'median ms', 'p90 ms'),
        [
            (step, entry['num'], 1e3 * entry['median'], 1e3 * entry['p90'])
            for step, entry in timing.items()
            if entry['num']
        ],
    )
    return timing


def write_page(
    output: Output, path: Path, reports: Sequence[ReplayReport], metric: RelationMetric | None
) -> None:
    """A page with curves of each bag, pictures of its imitations, and these in 3-D."""
    from spatial_relations_ros.visualization import write_report

    shown: list[ShownImitation] = []
    sections: list[ReportSection] = []
    for report in reports:
        cases = [] if metric is None else _shown(report, metric, several=len(reports) > 1)
        sections.append(_section(report, cases))
        shown += cases
    names = ', '.join(report.bag_name for report in reports)
    write_report(path, shown[:MAX_SHOWN], title=f'Replay of {names}', sections=sections)
    output.say(f'report: [bold]{escape(str(path))}[/]')


def _shown(report: ReplayReport, metric: RelationMetric, *, several: bool) -> list[ShownImitation]:
    shown = []
    for frame in report.frames:
        if frame.imitation is None or frame.scenes is None or not frame.imitation.answers:
            continue
        title = f'frame {frame.frame_idx}'
        shown.append(
            shown_imitation(
                metric, *frame.scenes, frame.imitation,
                table_height=frame.table_height, is_timed=False,
                title=f'{report.bag_name}, {title}' if several else title,
            )
        )  # fmt: skip
    return shown


def _section(report: ReplayReport, cases: Sequence[ShownImitation]) -> ReportSection:
    from spatial_relations_ros.evaluation.replay_curves import replay_curves
    from spatial_relations_ros.evaluation.replay_report import summary
    from spatial_relations_ros.visualization import ReportSection, before_after, draw_timelines

    pictures = [
        (
            case.title,
            before_after(
                case.reference,
                case.before,
                case.before.with_poses(*case.answers[0].poses),
                table_height=case.table_height,
            ),
        )
        for case in cases[:MAX_SHOWN]
    ]
    start_ns = report.frames[0].stamp_ns
    facts = [(name.removeprefix('num_'), str(count)) for name, count in summary(report).items()]
    facts += [
        (
            'demonstration',
            f'{(item.start_ns - start_ns) / 1e9:.2f} to {(item.end_ns - start_ns) / 1e9:.2f} s, '
            f'frames {item.first_frame} to {item.last_frame}',
        )
        for item in report.demonstrations
    ]
    facts += [(f'{count} times', reason) for reason, count in _reasons(report)]
    curves = [('over the time of the bag', draw_timelines(replay_curves(report)))]
    return ReportSection(report.bag_name, tuple(facts), (*curves, *pictures))
