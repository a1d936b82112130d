"""A replay's course in time, to be drawn."""

from __future__ import annotations

from spatial_relations_ros.evaluation.replay import ReplayReport
from spatial_relations_ros.visualization import Curve, Timeline


def replay_curves(report: ReplayReport) -> tuple[Timeline, ...]:
    """Distances with what imitations made of them, and the support of each object.

    Times are seconds after the first cloud.
    """
    start_ns = report.frames[0].stamp_ns

    def seconds(stamp_ns: int) -> float:
        return (stamp_ns - start_ns) / 1e9

    times = [seconds(frame.stamp_ns) for frame in report.frames]
    spans = tuple((seconds(item.start_ns), seconds(item.end_ns)) for item in report.demonstrations)
    timelines = []
    if report.options.reference_ids is not None:
        distances = Curve('distance as it stands', times, [f.distance for f in report.frames])
        after = [
            frame.imitation.answers[0].distance
            if frame.imitation is not None and frame.imitation.answers
            else None
            for frame in report.frames
        ]
        answers = Curve('after the best answer', times, after, is_line=False)
        timelines.append(
            Timeline('Distance to the demonstration', 'distance', (distances, answers), spans)
        )
    object_ids = sorted({key for frame in report.frames for key in frame.states})
    supports = tuple(
        Curve(
            object_id,
            times,
            [
                frame.states[object_id].support if object_id in frame.states else None
                for frame in report.frames
            ],
        )
        for object_id in object_ids
    )
    timelines.append(Timeline('Support of tracked poses in the clouds', 'support', supports))
    return tuple(timelines)
