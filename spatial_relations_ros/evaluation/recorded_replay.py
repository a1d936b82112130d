"""A replay in a Rerun recording."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import Scene
from spatial_relations_ros.evaluation.replay import ReplayedFrame, ReplayReport
from spatial_relations_ros.perception.series import NS_PER_SEC
from spatial_relations_ros.visualization import OBJECT_COLOURS, draw_projections
from spatial_relations_ros.visualization.palette import Rgb
from spatial_relations_ros.visualization.recorded_imitation import GHOST_ALPHA
from spatial_relations_ros.visualization.recordings import Recording

OTHER_COLOUR: Rgb = (0.55, 0.58, 0.64)

Projections = Callable[[Scene], NDArray[np.float32]]


def record_replay(
    recording: Recording, report: ReplayReport, projections: Projections | None
) -> None:
    """Logs all frames on the timelines ``frame`` and ``bag_time`` (seconds from the first).

    Entities: ``objects/ID``, ``targets/ID`` (the best answer, translucent), ``projections``,
    ``distance`` of the scenes as they stand, ``answer/distance`` and ``answer/feasible``, and
    ``log`` with what was wrong.

    Args:
        recording: to log to.
        report: of the replay.
        projections: gives the network's images of a scene; None leaves them out.
    """
    start_ns = report.frames[0].result.stamp_ns if report.frames else 0
    for frame in report.frames:
        seconds = (frame.result.stamp_ns - start_ns) / NS_PER_SEC
        recording.set_time(frame=frame.frame_idx, bag_time=float(seconds))
        _record_frame(recording, frame, report, projections)


def _record_frame(
    recording: Recording,
    frame: ReplayedFrame,
    report: ReplayReport,
    projections: Projections | None,
) -> None:
    result, options = frame.result, report.options
    pairs = [pair for pair in (options.reference_ids, options.test_ids) if pair is not None]
    colours = {
        object_id: colour
        for pair in pairs
        for object_id, colour in zip(pair, OBJECT_COLOURS, strict=False)
    }
    for object_id, item in result.objects.items():
        colour = colours.get(object_id, OTHER_COLOUR)
        recording.log_objects(('objects',), [item], colours=[colour])
    for object_id, reason in result.rejected.items():
        recording.log_text(('log', object_id), reason, is_bad=True)
    if result.problem or frame.reason:
        recording.log_text(('log',), result.problem or frame.reason or '', is_bad=True)
    if frame.distance is None:
        return
    recording.log_number(('distance',), frame.distance)
    if projections is not None and frame.imitation is not None:
        for name, pair in zip(('reference', 'test'), pairs, strict=True):
            picture = draw_projections(projections(result.scene(*pair)), object_ids=pair, cell=160)
            recording.log_image(('projections', name), picture)
    if frame.imitation is None or not frame.imitation.answers or options.test_ids is None:
        return
    best = frame.imitation.answers[0]
    recording.log_number(('answer', 'distance'), best.distance)
    recording.log_number(('answer', 'feasible'), float(best.feasible))
    placed = best.scene(result.scene(*options.test_ids))
    recording.log_objects(('targets',), placed.objects, alpha=GHOST_ALPHA)
    recording.log_text(('log',), frame.imitation.message, is_bad=not frame.imitation.success)
