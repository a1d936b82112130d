"""Shapes of objects, small enough for a page."""

from __future__ import annotations

import base64
import hashlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import SceneObject
from spatial_relations_ros.visualization.simplification import simplified_mesh

MAX_POINTS = 8000

_LEVELS = 65535


class ModelStore:
    """Models by the content of their shape, each stored once.

    A model has ``low`` and ``step`` (positions are low + step * integer, metres, object frame),
    ``positions`` (base64 of little-endian uint16 triples) and, for meshes, ``triangles`` (base64
    of little-endian uint16 or uint32 triples, ``wide`` telling which).

    Args:
        num_triangles: meshes are simplified to at most about so many.
    """

    def __init__(self, num_triangles: int) -> None:
        self.models: dict[str, dict[str, Any]] = {}
        self._num_triangles = num_triangles

    def add(self, item: SceneObject) -> str:
        """The key of the object's model."""
        digest = hashlib.sha256()
        if item.mesh is None:
            digest.update(item.points.tobytes())
        else:
            digest.update(item.mesh.vertices.tobytes())
            digest.update(item.mesh.triangles.tobytes())
        key = digest.hexdigest()[:12]
        if key not in self.models:
            self.models[key] = self._model(item)
        return key

    def _model(self, item: SceneObject) -> dict[str, Any]:
        if item.mesh is None:
            stride = max(1, -(-len(item.points) // MAX_POINTS))
            return _positions(item.points[::stride])
        mesh = simplified_mesh(item.mesh, self._num_triangles)
        wide = len(mesh.vertices) > _LEVELS
        indices = mesh.triangles.astype('<u4' if wide else '<u2')
        return {**_positions(mesh.vertices), 'triangles': _base64(indices), 'wide': wide}


def _positions(points: NDArray[np.float32]) -> dict[str, Any]:
    low = points.min(axis=0).astype(np.float64)
    step = max(float(np.ptp(points, axis=0).max()), 1e-6) / _LEVELS
    levels = np.round((points - low) / step).astype('<u2')
    return {
        'low': [round(float(value), 7) for value in low],
        'step': step,
        'positions': _base64(levels),
    }


def _base64(values: NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode('ascii')
