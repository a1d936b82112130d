"""Mass properties of watertight meshes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import TriangleMesh


@dataclass(frozen=True, eq=False)
class MassProperties:
    """Mass in kg and its centre (3,) in the mesh's frame, metres."""

    mass: float
    centre: NDArray[np.float64]


def mass_properties(mesh: TriangleMesh, *, density: float) -> MassProperties:
    """Mass and centre of mass of the volume within a watertight mesh.

    Sums the signed tetrahedra between the triangles and the origin (divergence theorem).
    """
    corners = mesh.vertices.astype(np.float64)[mesh.triangles]
    volumes = np.einsum('ij,ij->i', corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    volume = float(volumes.sum())
    centre = (volumes[:, None] * corners.sum(axis=1) / 4.0).sum(axis=0) / volume
    return MassProperties(volume * density, centre)
