"""All pictures of one imitation, in a folder."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import Scene
from spatial_relations_ros.visualization.camera import frame_objects, outline_points
from spatial_relations_ros.visualization.curves import draw_distance_curve
from spatial_relations_ros.visualization.images import Image, write_image
from spatial_relations_ros.visualization.projections import draw_projections
from spatial_relations_ros.visualization.rendering import render_scene
from spatial_relations_ros.visualization.sheets import before_after, moved_objects

Projections = Callable[[Scene], NDArray[np.float32]]
"""The network's six images (3, 2, S, S) of a scene."""


def write_imitation_pictures(
    folder: Path | str,
    *,
    reference: Scene,
    before: Scene,
    after: Scene | None,
    projections: Projections,
    distance_history: NDArray[np.floating] | Sequence[float],
    table_height: float | None = None,
) -> tuple[Path, ...]:
    """Writes what there is to see of an imitation.

    The files: ``overview.png`` (demonstration, before and after in a row), ``reference.png``,
    ``test_before.png``, ``test_after.png``, the same three names with ``_projections``, and
    ``distance.png``. Without an answer there is no overview and nothing of after.

    Args:
        folder: where to; made when missing.
        reference: the demonstrated scene.
        before: the test scene as it stood.
        after: the test scene with the objects at their targets; None when there is no answer.
        projections: gives the network's images of a scene.
        distance_history: (S,) distance of the nearest placement so far at each step.
        table_height: world z of the table in the test scene; its lowest point before by default.

    Returns:
        The paths written.
    """
    folder = Path(folder)
    scenes = {'reference': reference, 'test_before': before}
    if after is not None:
        scenes['test_after'] = after
    camera = frame_objects([scene.objects for scene in (before, after) if scene is not None])
    if table_height is None:
        table_height = min(float(outline_points(item)[:, 2].min()) for item in before.objects)
    pictures: dict[str, Image] = {
        'reference': render_scene(reference.objects),
        'test_before': render_scene(before.objects, camera=camera, table_height=table_height),
        'distance': draw_distance_curve(distance_history),
    }
    if after is not None:
        pictures['overview'] = before_after(reference, before, after, table_height=table_height)
        pictures['test_after'] = render_scene(
            after.objects,
            ghosts=moved_objects(before, after),
            camera=camera,
            table_height=table_height,
        )
    for name, scene in scenes.items():
        pictures[f'{name}_projections'] = draw_projections(
            projections(scene), object_ids=scene.object_ids
        )
    return tuple(write_image(folder / f'{name}.png', image) for name, image in pictures.items())
