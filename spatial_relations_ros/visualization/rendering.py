"""Pictures of objects on a table, by ray casting: no display, no GPU, no OpenGL."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from spatial_relations_ros.core import ConfigError, SceneObject
from spatial_relations_ros.visualization.camera import Camera, frame_objects, outline_points
from spatial_relations_ros.visualization.images import Image
from spatial_relations_ros.visualization.lighting import Sun
from spatial_relations_ros.visualization.palette import (
    HORIZON,
    OBJECT_COLOURS,
    Rgb,
    bytes_from_linear,
    linear_from_srgb,
)
from spatial_relations_ros.visualization.renderer import Layer, Renderer
from spatial_relations_ros.visualization.table import Table


def render_scene(
    objects: Sequence[SceneObject],
    *,
    ghosts: Sequence[SceneObject] = (),
    camera: Camera | None = None,
    table_height: float | None = None,
    colours: Sequence[Rgb] = OBJECT_COLOURS,
    ghost_colours: Sequence[Rgb] | None = None,
    width: int = 800,
    height: int = 600,
) -> Image:
    """A picture of objects on a table.

    Args:
        objects: what is solid; give (base, relative) to get their usual colours. Meshes are
            drawn where an object has one, its cloud otherwise.
        ghosts: drawn translucent in the colour of the solid object with the same id; without
            one, in the colours by position.
        camera: where from; a camera that frames everything by default. Use one camera for
            pictures that are to be compared.
        table_height: world z of the table; the lowest point of the objects by default.
        colours: by position in ``objects``; repeated when there are more objects.
        ghost_colours: of each of ``ghosts``, instead of those above.
        width: pixels, when no camera is given.
        height: pixels, when no camera is given.

    Returns:
        (height, width, 3) uint8 RGB. Without any object: the bare background.

    Raises:
        ConfigError: for a size without pixels.
    """
    if width < 1 or height < 1:
        raise ConfigError(f'a picture needs pixels, got {width} x {height}')
    everything = [*objects, *ghosts]
    if not everything:
        bare = np.empty((height, width, 3), dtype=np.float32)
        bare[:] = HORIZON
        return bytes_from_linear(linear_from_srgb(bare))
    if camera is None:
        camera = frame_objects([everything], width=width, height=height)
    points = np.concatenate([outline_points(scene_object) for scene_object in everything])
    solid = np.concatenate([outline_points(item) for item in (objects or everything)])
    lowest = float(solid[:, 2].min()) if table_height is None else table_height
    by_id = {item.object_id: colours[idx % len(colours)] for idx, item in enumerate(objects)}
    if ghost_colours is None:
        ghost_colours = [
            by_id.get(item.object_id, colours[idx % len(colours)])
            for idx, item in enumerate(ghosts)
        ]
    renderer = Renderer(
        camera,
        Table.below(points, lowest),
        Sun.beside_camera(camera.world_from_camera.rotation),
        Layer.of(objects, [by_id[item.object_id] for item in objects]),
        Layer.of(ghosts, ghost_colours),
    )
    return renderer.picture(points)
