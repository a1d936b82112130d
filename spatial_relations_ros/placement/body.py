"""An object prepared for contact queries, and the same at a pose."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import open3d as o3d
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from spatial_relations_ros.core import Pose, TriangleMesh
from spatial_relations_ros.placement.convex_parts import ConvexPart, convex_parts
from spatial_relations_ros.placement.model import ObjectModel
from spatial_relations_ros.placement.ray_casting import ray_casting_scene

FloatArray = NDArray[np.float64]

_SHARP_EDGE_COSINE = np.cos(np.deg2rad(20.0))
_EDGE_SPACING = 0.003
_MAX_FEATURES = 2200
_NUM_SURFACE_POINTS = 1500
_COARSE_STEP = 4


@dataclass(frozen=True, eq=False)
class Body:
    """An object model with the points at which its contacts are looked for.

    Attributes:
        model: the object.
        surface: ray casting structure of its mesh, object frame.
        points: (P, 3) float32, object frame: vertices and samples of sharp edges, then samples
            of the faces. Two surfaces meet at an edge of one of them or flat on a face, so that
            these points find a contact to a fraction of a millimetre.
        normals: (P, 3) float32, outward; means of the faces that meet at an edge or vertex.
        num_features: how many of the points lie on edges and vertices.
        radius: of the sphere around the origin that holds the object, metres.
    """

    model: ObjectModel
    surface: o3d.t.geometry.RaycastingScene
    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    num_features: int
    radius: float

    @staticmethod
    def of(model: ObjectModel) -> Body:
        """Prepares a model; deterministic."""
        rng = np.random.default_rng(0)
        features, feature_normals = _feature_points(model.mesh)
        if len(features) > _MAX_FEATURES:
            kept = np.sort(rng.choice(len(features), _MAX_FEATURES, replace=False))
            features, feature_normals = features[kept], feature_normals[kept]
        faces, face_normals = _face_points(model.mesh, _NUM_SURFACE_POINTS, rng)
        return Body(
            model,
            ray_casting_scene(model.mesh),
            np.concatenate([features, faces]).astype(np.float32),
            np.concatenate([feature_normals, face_normals]).astype(np.float32),
            len(features),
            float(np.linalg.norm(model.mesh.vertices, axis=1).max()),
        )

    @cached_property
    def hull_planes(self) -> FloatArray:
        """Planes (F, 4) of the convex hull, object frame: normal and offset, negative inside."""
        planes: FloatArray = ConvexHull(self.model.mesh.vertices.astype(np.float64)).equations
        return np.unique(planes.round(6), axis=0)

    @cached_property
    def convex_parts(self) -> tuple[ConvexPart, ...]:
        """Convex parts that make up the body, object frame; seconds for a hollow one."""
        return convex_parts(self.model.mesh)

    @cached_property
    def face_points(self) -> NDArray[np.float32]:
        """The points that are spread evenly over the surface, object frame."""
        return self.points[self.num_features :]

    @cached_property
    def coarse(self) -> Body:
        """The same body with a quarter of the points, for first searches."""
        return replace(
            self,
            points=self.points[::_COARSE_STEP],
            normals=self.normals[::_COARSE_STEP],
            num_features=-(-self.num_features // _COARSE_STEP),
        )


@dataclass(frozen=True, eq=False)
class Placed:
    """A body at a pose in the world: p_world = rotation @ p_object + translation."""

    body: Body
    rotation: FloatArray
    translation: FloatArray

    @cached_property
    def world_points(self) -> FloatArray:
        """Contact points (P, 3) in the world frame."""
        return self.body.points @ self.rotation.T + self.translation

    def world_normals(self) -> FloatArray:
        """Outward normals (P, 3) of the contact points in the world frame."""
        return self.body.normals @ self.rotation.T

    @cached_property
    def world_vertices(self) -> FloatArray:
        """Mesh vertices (V, 3) in the world frame."""
        return self.body.model.mesh.vertices @ self.rotation.T + self.translation

    def centre_of_mass(self) -> FloatArray:
        """(3,), world frame."""
        centre = self.rotation @ self.body.model.mass_properties.centre + self.translation
        return np.asarray(centre, dtype=np.float64)

    def coarse(self) -> Placed:
        """With fewer contact points."""
        return Placed(self.body.coarse, self.rotation, self.translation)

    def to_object(self, points: FloatArray) -> NDArray[np.float32]:
        """World points (..., 3) in the object's frame."""
        return ((points - self.translation) @ self.rotation).astype(np.float32)

    def moved(self, offset: FloatArray) -> Placed:
        """Shifted in the world."""
        return Placed(self.body, self.rotation, self.translation + offset)

    def turned(self, rotation: FloatArray) -> Placed:
        """Turned about the world's origin."""
        return Placed(self.body, rotation @ self.rotation, rotation @ self.translation)

    def on_table(self) -> Placed:
        """Shifted vertically so that the lowest vertex has z = 0."""
        lowest = float(self.world_vertices[:, 2].min())
        return self.moved(np.array([0.0, 0.0, -lowest]))

    def pose(self) -> Pose:
        """world_from_object."""
        return Pose.from_rotation(self.rotation, self.translation)


def _triangle_normals(mesh: TriangleMesh) -> tuple[FloatArray, FloatArray]:
    corners = mesh.vertices.astype(np.float64)[mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled_area = np.linalg.norm(normals, axis=1)
    return normals / np.maximum(doubled_area, 1e-15)[:, None], doubled_area / 2.0


def _feature_points(mesh: TriangleMesh) -> tuple[FloatArray, FloatArray]:
    normals, areas = _triangle_normals(mesh)
    vertices = mesh.vertices.astype(np.float64)
    vertex_normals = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(vertex_normals, mesh.triangles[:, corner], normals * areas[:, None])
    half_edges = mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    owner = np.repeat(np.arange(len(mesh.triangles)), 3)
    order = np.lexsort(np.sort(half_edges, axis=1).T)
    edges = np.sort(half_edges, axis=1)[order].reshape(-1, 2, 2)[:, 0]
    left, right = normals[owner[order].reshape(-1, 2)].transpose(1, 0, 2)
    sharp = np.einsum('ij,ij->i', left, right) < _SHARP_EDGE_COSINE
    points, point_normals = [vertices], [vertex_normals]
    for (start, end), normal in zip(edges[sharp], (left + right)[sharp], strict=True):
        length = np.linalg.norm(vertices[end] - vertices[start])
        steps = int(np.ceil(length / _EDGE_SPACING))
        share = (np.arange(1, steps) / steps)[:, None] if steps > 1 else np.zeros((0, 1))
        points.append(vertices[start] * (1.0 - share) + vertices[end] * share)
        point_normals.append(np.broadcast_to(normal, (len(share), 3)))
    all_normals = np.concatenate(point_normals)
    lengths = np.linalg.norm(all_normals, axis=1, keepdims=True)
    return np.concatenate(points), all_normals / np.maximum(lengths, 1e-12)


def _face_points(
    mesh: TriangleMesh, num_points: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    normals, areas = _triangle_normals(mesh)
    cumulative = np.cumsum(areas)
    picks = (np.arange(num_points) + rng.random(num_points)) * (cumulative[-1] / num_points)
    triangle_idx = np.minimum(np.searchsorted(cumulative, picks), len(areas) - 1)
    corners = mesh.vertices.astype(np.float64)[mesh.triangles[triangle_idx]]
    root = np.sqrt(rng.random(num_points))[:, None]
    along = rng.random(num_points)[:, None]
    points = corners[:, 0] * (1.0 - root)
    points = points + corners[:, 1] * root * (1.0 - along) + corners[:, 2] * root * along
    return points, normals[triangle_idx]
