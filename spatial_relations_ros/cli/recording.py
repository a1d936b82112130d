"""``--rerun``: recordings for the Rerun viewer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape

from spatial_relations_ros.cli.output import Output

if TYPE_CHECKING:
    from spatial_relations_ros.evaluation.replay import ReplayReport
    from spatial_relations_ros.learning import RelationMetric
    from spatial_relations_ros.visualization import ShownImitation

RerunOption = Annotated[
    str | None,
    typer.Option(
        '--rerun',
        metavar='FILE|spawn|ADDRESS',
        show_default=False,
        help='Record for Rerun: to an .rrd file, a viewer started here, or a running one.',
    ),
]


def check_recording(target: str | None) -> None:
    """Refuses before the work what could not be recorded after it.

    Raises:
        ConfigError: for a target that is none, or without rerun-sdk.
    """
    if target is not None:
        from spatial_relations_ros.visualization.recordings import check_target, require_rerun

        check_target(target)
        require_rerun()


def record_shown(
    output: Output, target: str, shown: ShownImitation, metric: RelationMetric
) -> None:
    """Records an imitation, and says so."""
    from spatial_relations_ros.visualization.recorded_imitation import record_imitation
    from spatial_relations_ros.visualization.recordings import Recording

    with Recording(target, name=shown.title) as recording:
        record_imitation(recording, shown, projections=metric.projections)
    output.say(f'recording: [bold]{escape(target)}[/]')


def record_reports(
    output: Output, target: str, reports: Sequence[ReplayReport], metric: RelationMetric | None
) -> None:
    """Records replays, those of several bags below the bags' names; says so."""
    from spatial_relations_ros.evaluation.recorded_replay import record_replay
    from spatial_relations_ros.visualization.recordings import Recording

    projections = None if metric is None else metric.projections
    with Recording(target, name=', '.join(report.bag_name for report in reports)) as recording:
        for report in reports:
            path = () if len(reports) == 1 else (report.bag_name,)
            record_replay(recording, report, projections, path=path)
    output.say(f'recording: [bold]{escape(target)}[/]')
