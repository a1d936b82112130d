"""A replay's report as JSON and CSV content; timing apart."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from spatial_relations_ros.evaluation.demonstrations import Demonstration
from spatial_relations_ros.evaluation.entries import answer_entry
from spatial_relations_ros.evaluation.replay import ReplayedFrame, ReplayReport
from spatial_relations_ros.evaluation.replay_jobs import FailedReplay
from spatial_relations_ros.imitation import ImitationResult

CSV_COLUMNS = (
    'bag', 'frame', 'stamp_ns', 'num_objects', 'distance', 'imitated', 'success',
    'answer_distance', 'feasible', 'tx', 'ty', 'tz', 'qw', 'qx', 'qy', 'qz', 'reason',
)  # fmt: skip


def report_content(report: ReplayReport) -> dict[str, Any]:
    """Everything but timing; the same for the same input."""
    return {
        'bag': report.bag_name,
        'topics': {
            'points': report.topics.points,
            'tracked_objects': list(report.topics.tracked_objects),
            'pose_topics': dict(sorted(report.topics.pose_topics.items())),
        },
        'reference_ids': report.options.reference_ids,
        'test_ids': report.options.test_ids,
        'model_hash': report.model_hash,
        'summary': summary(report),
        'demonstrations': [_demonstration_entry(report, item) for item in report.demonstrations],
        'requests': [
            {'at_sec': request.at_sec, 'frame': request.frame_idx} for request in report.requests
        ],
        'frames': [_frame_entry(frame) for frame in report.frames],
        'dropped': [
            {'topic': item.topic, 'time_ns': item.time_ns, 'reason': item.reason}
            for item in report.dropped
        ],
    }


def summary(report: ReplayReport) -> dict[str, int]:
    """Counts over the frames."""
    imitations = [frame.imitation for frame in report.frames if frame.imitation is not None]
    return {
        'num_frames': len(report.frames),
        'num_dropped': len(report.dropped),
        'num_problems': sum(frame.problem is not None for frame in report.frames),
        'num_demonstrations': len(report.demonstrations),
        'num_comparable': sum(frame.distance is not None for frame in report.frames),
        'num_imitations': len(imitations),
        'num_successes': sum(imitation.success for imitation in imitations),
    }


def _demonstration_entry(report: ReplayReport, found: Demonstration) -> dict[str, Any]:
    imitated = [
        frame.frame_idx
        for frame in report.frames[found.first_frame : found.last_frame + 1]
        if frame.imitation is not None
    ]
    return {
        'first_frame': found.first_frame,
        'settled_frame': found.settled_frame,
        'last_frame': found.last_frame,
        'start_ns': found.start_ns,
        'end_ns': found.end_ns,
        'imitated_frames': imitated,
    }


def _frame_entry(frame: ReplayedFrame) -> dict[str, Any]:
    return {
        'frame': frame.frame_idx,
        'stamp_ns': frame.stamp_ns,
        'objects': list(frame.object_ids),
        'support': {
            object_id: _rounded(status.support)
            for object_id, status in sorted(frame.states.items())
        },
        'rejected': dict(sorted(frame.rejected.items())),
        'problem': frame.problem,
        'table_height': _rounded(frame.table_height),
        'distance': _rounded(frame.distance),
        'reason': frame.reason,
        'imitation': None if frame.imitation is None else _imitation_entry(frame.imitation),
    }


def _imitation_entry(imitation: ImitationResult) -> dict[str, Any]:
    return {
        'success': imitation.success,
        'message': imitation.message,
        'answers': [answer_entry(answer) for answer in imitation.answers],
        'initial_distance': float(imitation.initial_distance),
        'steps': imitation.num_steps,
    }


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(float(value), 9)


def reports_content(replays: Sequence[ReplayReport | FailedReplay]) -> dict[str, Any]:
    """Of several bags: ``replays`` in the order given and counts over all of them."""
    counts: Counter[str] = Counter()
    for replay in replays:
        if isinstance(replay, ReplayReport):
            counts.update(summary(replay))
    return {
        'summary': {'num_bags': len(replays), **counts},
        'replays': [
            report_content(replay)
            if isinstance(replay, ReplayReport)
            else {'bag': replay.bag_name, 'error': str(replay.error)}
            for replay in replays
        ],
    }


def report_csv(*reports: ReplayReport) -> str:
    """One row a frame; the pose is the best answer's, of the relative."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    writer.writerow(CSV_COLUMNS)
    for report in reports:
        for frame in report.frames:
            writer.writerow([report.bag_name, *_csv_row(frame)])
    return text.getvalue()


def _csv_row(frame: ReplayedFrame) -> list[Any]:
    row: list[Any] = [
        frame.frame_idx,
        frame.stamp_ns,
        len(frame.object_ids),
        '' if frame.distance is None else f'{frame.distance:.6f}',
        int(frame.imitation is not None),
    ]
    if frame.imitation is None or not frame.imitation.answers:
        row += [''] * 10
    else:
        best = frame.imitation.answers[0]
        target = best.placements[1].target
        row += [int(frame.imitation.success), f'{best.distance:.6f}', int(best.feasible)]
        row += [f'{value:.6f}' for value in (*target.translation, *target.quat_wxyz)]
    return [*row, frame.problem or frame.reason or '']


def timing_content(*reports: ReplayReport) -> dict[str, Any]:
    """Wall times of the steps, seconds."""
    frames = [frame for report in reports for frame in report.frames]
    imitations = [frame.imitation for frame in frames if frame.imitation is not None]
    return {
        'perception': _spread([frame.perception_sec for frame in frames]),
        'distance': _spread([frame.metric_sec for frame in frames if frame.distance is not None]),
        'imitation': _spread([imitation.duration_sec for imitation in imitations]),
    }


def _spread(seconds: Sequence[float]) -> dict[str, float | int | None]:
    if not seconds:
        return {'num': 0, 'median': None, 'p90': None, 'max': None}
    return {
        'num': len(seconds),
        'median': float(np.median(seconds)),
        'p90': float(np.percentile(seconds, 90)),
        'max': float(np.max(seconds)),
    }
