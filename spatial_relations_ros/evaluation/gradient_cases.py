"""Cases and variants of the comparison of gradients."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from spatial_relations_ros.core import Pose, Scene
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.learning import RelationMetric
from spatial_relations_ros.projection import coarse_to_fine

SHIFT = (0.1, 0.3)
TURN_DEG = (10.0, 40.0)


@dataclass(frozen=True)
class Variant:
    """One way to differentiate the projection.

    Attributes:
        name: in tables.
        settings: of the projection's configuration.
        narrows: whether the soft gradient goes from coarse to fine over an optimisation.
    """

    name: str
    settings: dict[str, Any] = field(default_factory=dict)
    narrows: bool = False

    def narrow(self, metric: RelationMetric, progress: float) -> None:
        """Sets the width of the soft gradient for a share of the steps done, 0 to 1."""
        if self.narrows:
            metric.encoder.projection = dataclasses.replace(
                metric.encoder.projection, soft_width_px=coarse_to_fine(progress)
            )


VARIANTS = (
    Variant('silhouette', {'gradient': 'silhouette'}),
    Variant('sobel', {'gradient': 'sobel'}),
    Variant('released', {'gradient': 'released'}),
    Variant('soft, 1 px', {'gradient': 'soft', 'soft_width_px': 1.0}),
    Variant('soft, coarse to fine', {'gradient': 'soft'}, narrows=True),
    Variant('straight through, 0.7 px', {'gradient': 'straight_through', 'soft_width_px': 0.7}),
)


@dataclass(frozen=True, eq=False)
class DisplacedScene:
    """A demonstration and a copy of it whose relative object stands elsewhere.

    Attributes:
        reference: the demonstration.
        scene: the copy.
        extent: longest side of the demonstration's bounding box, metres.
    """

    reference: Scene
    scene: Scene
    extent: float


def displace(scene: Scene, rng: np.random.Generator) -> DisplacedScene:
    """Moves the relative object in a random direction and turns it about a random axis.

    By 0.1 to 0.3 of the scene's extent, and by 10 to 40 degrees about the middle of its cloud.
    """
    directions = rng.normal(size=(2, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    turn = matrix_from_rotvec(math.radians(rng.uniform(*TURN_DEG)) * directions[1])
    points = np.concatenate([item.world_points for item in scene.objects])
    extent = float(np.ptp(points, axis=0).max())
    pose = scene.relative.world_from_object
    middle = scene.relative.world_points.astype(np.float64).mean(axis=0)
    moved = Pose.from_rotation(
        turn @ pose.rotation,
        turn @ (pose.translation - middle) + middle + extent * rng.uniform(*SHIFT) * directions[0],
    )
    return DisplacedScene(scene, scene.with_poses(scene.base.world_from_object, moved), extent)
