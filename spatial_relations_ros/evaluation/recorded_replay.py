"""A replay in a Rerun recording."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import Scene
from spatial_relations_ros.evaluation.replay import ReplayReport
from spatial_relations_ros.imitation import ImitationResult
from spatial_relations_ros.perception.series import NS_PER_SEC
from spatial_relations_ros.visualization import draw_projections
from spatial_relations_ros.visualization.recorded_imitation import GHOST_ALPHA, PROJECTION_CELL
from spatial_relations_ros.visualization.recordings import Recording

Projections = Callable[[Scene], NDArray[np.float32]]


def record_replay(
    recording: Recording,
    report: ReplayReport,
    projections: Projections | None,
    *,
    path: Sequence[str] = (),
) -> None:
    """Logs all frames on the timelines ``frame`` and ``bag_time`` (seconds from the first).

    Entities: ``distance`` of the scenes as they stand, and ``log`` with what was wrong; of frames
    with an imitation also ``reference/ID``, ``test/ID``, ``targets/ID`` (the best answer,
    translucent), ``projections``, ``answer/distance`` and ``answer/feasible``.

    Args:
        recording: to log to.
        report: of the replay.
        projections: gives the network's images of a scene; None leaves them out.
        path: of all entities.
    """
    start_ns = report.frames[0].stamp_ns if report.frames else 0
    for frame in report.frames:
        seconds = (frame.stamp_ns - start_ns) / NS_PER_SEC
        recording.set_time(frame=frame.frame_idx, bag_time=float(seconds))
        for object_id, reason in frame.rejected.items():
            recording.log_text((*path, 'log', object_id), reason, is_bad=True)
        problem = frame.problem or frame.reason
        if problem:
            recording.log_text((*path, 'log'), problem, is_bad=True)
        if frame.distance is not None:
            recording.log_number((*path, 'distance'), frame.distance)
        if frame.imitation is not None and frame.scenes is not None:
            _record_imitation(recording, frame.imitation, frame.scenes, projections, tuple(path))


def _record_imitation(
    recording: Recording,
    imitation: ImitationResult,
    scenes: tuple[Scene, Scene],
    projections: Projections | None,
    path: tuple[str, ...],
) -> None:
    for name, scene in zip(('reference', 'test'), scenes, strict=True):
        recording.log_objects((*path, name), scene.objects)
        if projections is not None:
            picture = draw_projections(
                projections(scene), object_ids=scene.object_ids, cell=PROJECTION_CELL
            )
            recording.log_image((*path, 'projections', name), picture)
    recording.log_text((*path, 'log'), imitation.message, is_bad=not imitation.success)
    if not imitation.answers:
        return
    best = imitation.answers[0]
    recording.log_number((*path, 'answer', 'distance'), best.distance)
    recording.log_number((*path, 'answer', 'feasible'), float(best.feasible))
    placed = best.scene(scenes[1]).objects
    recording.log_objects((*path, 'targets'), placed, alpha=GHOST_ALPHA)
