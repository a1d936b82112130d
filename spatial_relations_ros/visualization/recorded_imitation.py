"""An imitation in a Rerun recording."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import Scene
from spatial_relations_ros.visualization.projections import draw_projections
from spatial_relations_ros.visualization.recordings import Recording
from spatial_relations_ros.visualization.shown_imitation import ShownImitation, way_to

GHOST_ALPHA = 0.35
PROJECTION_CELL = 160


def record_imitation(
    recording: Recording,
    shown: ShownImitation,
    *,
    projections: Callable[[Scene], NDArray[np.float32]],
    path: Sequence[str] = (),
) -> None:
    """Logs the demonstration, the way of the test objects to the best answer, and all answers.

    On the timeline ``moment``: ``test`` with the six projections, ``distance`` and ``feasible``
    (0 or 1) as they changed. On ``step``: ``search``, the distance at each step. Without
    time: ``reference`` with its projections and ``answers``.

    Args:
        recording: to log to; times set before stay set.
        shown: the imitation.
        projections: gives the network's images of a scene.
        path: of all entities.
    """
    reference = shown.reference
    recording.log_objects((*path, 'reference'), reference.objects)
    recording.log_image((*path, 'projections', 'reference'), _picture(reference, projections))
    for idx, answer in enumerate(shown.answers):
        scene = shown.before.with_poses(*answer.poses)
        entity = (*path, 'answers', str(idx + 1))
        recording.log_objects(entity, scene.objects, alpha=GHOST_ALPHA)
        words = 'feasible' if answer.feasible else 'not feasible'
        recording.log_text(entity, f'distance {answer.distance:.4f}, {words}')
    for idx, step in enumerate(way_to(shown)):
        recording.set_time(moment=idx)
        scene = shown.before.with_poses(*step.poses)
        recording.log_objects((*path, 'test'), scene.objects)
        recording.log_image((*path, 'projections', 'test'), _picture(scene, projections))
        if step.distance is not None:
            recording.log_number((*path, 'distance'), step.distance)
        if step.feasible is not None:
            recording.log_number((*path, 'feasible'), float(step.feasible))
    for idx, value in enumerate(shown.history):
        recording.set_time(step=idx)
        recording.log_number((*path, 'search'), value)
    recording.log_text((*path, 'outcome'), shown.message, is_bad=not shown.success)


def _picture(
    scene: Scene, projections: Callable[[Scene], NDArray[np.float32]]
) -> NDArray[np.uint8]:
    return draw_projections(projections(scene), object_ids=scene.object_ids, cell=PROJECTION_CELL)
