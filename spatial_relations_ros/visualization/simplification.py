"""Meshes with fewer triangles, for what cannot show all of them."""

from __future__ import annotations

import numpy as np
import open3d as o3d

from spatial_relations_ros.core import TriangleMesh


def simplified_mesh(mesh: TriangleMesh, num_triangles: int) -> TriangleMesh:
    """The mesh with at most about so many triangles (quadric decimation); itself if it has."""
    if len(mesh.triangles) <= num_triangles:
        return mesh
    legacy = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(mesh.vertices.astype(np.float64)),
        o3d.utility.Vector3iVector(np.array(mesh.triangles)),
    )
    simple = legacy.simplify_quadric_decimation(num_triangles)
    if len(simple.triangles) == 0:
        return mesh
    return TriangleMesh(
        np.asarray(simple.vertices, dtype=np.float32),
        np.asarray(simple.triangles, dtype=np.int32),
    )
