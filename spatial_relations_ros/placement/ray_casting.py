"""Ray casting and distance queries on meshes (Open3D)."""

from __future__ import annotations

import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from spatial_relations_ros.core import TriangleMesh


def ray_casting_scene(mesh: TriangleMesh) -> o3d.t.geometry.RaycastingScene:
    """Ray casting and distance queries on a mesh."""
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        as_tensor(mesh.vertices), o3d.core.Tensor.from_numpy(mesh.triangles.astype(np.uint32))
    )
    return scene


def as_tensor(values: NDArray[np.floating]) -> o3d.core.Tensor:
    """A float32 tensor for Open3D's queries."""
    return o3d.core.Tensor.from_numpy(np.array(values, dtype=np.float32))
