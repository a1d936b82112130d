"""What perception needs to know of an object's model."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from spatial_relations_ros.core import TriangleMesh

NUM_SUPPORT_POINTS = 1000


@dataclass(frozen=True, eq=False)
class KnownModel:
    """An object's whole surface.

    Attributes:
        points: (N, 3) float32 spread over the surface, object frame, metres.
        mesh: the watertight surface in the object frame, where it is known.
    """

    points: NDArray[np.float32]
    mesh: TriangleMesh | None = None

    @cached_property
    def support_points(self) -> NDArray[np.float32]:
        """A part of ``points``, evenly picked, enough to compare with a depth image."""
        num_points = min(NUM_SUPPORT_POINTS, len(self.points))
        picks = np.linspace(0, len(self.points) - 1, num_points).round().astype(np.intp)
        return self.points[picks]

    @cached_property
    def tree(self) -> cKDTree:
        """Search tree over ``points``."""
        return cKDTree(self.points)


class ModelSource(Protocol):
    """Where models come from."""

    def find(self, object_id: str) -> KnownModel | None:
        """The model of an object, the same one at each call, or None when there is none.

        Raises:
            CloudFormatError: when there is one that cannot be used.
        """
        ...


class NoModels:
    """A source without models: every object is taken from the live cloud."""

    def find(self, object_id: str) -> KnownModel | None:  # noqa: ARG002 (as in the protocol)
        """None."""
        return None
