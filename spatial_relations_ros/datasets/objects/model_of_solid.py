"""From a solid of constructive geometry to an object."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from manifold3d import Manifold

from spatial_relations_ros.datasets.objects.solids import mesh_of
from spatial_relations_ros.placement.model import ObjectModel, Opening


def model_of_solid(
    family: str,
    solid: Manifold,
    dimensions: Mapping[str, float],
    *,
    opening: Opening | None = None,
    density: float = 1000.0,
    name: str = '',
) -> ObjectModel:
    """Moves a solid's bounding box to the origin and makes it an object."""
    low_x, low_y, low_z, high_x, high_y, high_z = solid.bounding_box()
    offset = -0.5 * np.array([low_x + high_x, low_y + high_y, low_z + high_z])
    mesh = mesh_of(solid.translate(tuple(offset)))
    rounded = {key: round(float(value), 6) for key, value in dimensions.items()}
    moved = opening.moved(offset) if opening is not None else None
    return ObjectModel(name or family, family, mesh, rounded, moved, density)
