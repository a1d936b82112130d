"""What the pose optimiser minimises."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from spatial_relations_ros.imitation.layout import Layout
from spatial_relations_ros.imitation.shape import Shape
from spatial_relations_ros.learning import RelationMetric, euclidean_distance
from spatial_relations_ros.projection import apply_poses

_PENETRATION_WEIGHT = 30.0
_CONTACT_WEIGHT = 2.0
_HEADING_WEIGHT = 0.5
_LAYOUT_STRIDE = 4
_LIKELY_SHARE = 0.75
# Without a calibration: dissimilar relations were trained to lie about 1 apart.
_UNCALIBRATED_SIMILAR_DISTANCE = 0.5


@dataclass(frozen=True, eq=False)
class Objective:
    """Distance to the demonstration, penetration, contact and heading, for batches of poses.

    Attributes:
        metric: the learned metric.
        clouds: (2, N, 3) clouds of base and relative as the metric takes them, object frames.
        shapes: solids of base and relative.
        reference_embedding: (64,) of the demonstration.
        extent: size of the test scene, metres; makes the physical terms scale-free.
        origin: (3,) world position that poses are counted from: single precision is enough near
            it, wherever the world's origin is.
        table_height: of the table in the world, metres.
        physics_weight: weight of penetration and contact; 0 leaves them out.
        heading: (2,) unit horizontal direction from base to relative to keep, or None.
        layout: of the demonstration.
        layout_weight: weight of a layout that is not the demonstration's.
    """

    metric: RelationMetric
    clouds: Tensor
    shapes: tuple[Shape, Shape]
    reference_embedding: Tensor
    extent: float
    origin: NDArray[np.float64]
    table_height: float
    physics_weight: float
    heading: Tensor | None
    layout: Layout
    layout_weight: float

    @property
    def similar_distance(self) -> float:
        """Scenes that are nearer to the demonstration show its relation, most likely.

        Three quarters of the distance at which that is as likely as not: about 0.8.
        """
        calibration = self.metric.calibration
        if calibration is None:
            return _UNCALIBRATED_SIMILAR_DISTANCE
        return _LIKELY_SHARE * calibration.same_relation_distance

    def confidence(self, distance: float, difference: float | None) -> float:
        """Probability that an answer imitates the demonstration, 0 to 1.

        Args:
            distance: of it under the metric.
            difference: of its arrangement and layout from the demonstration's, if that is known.
        """
        calibration, answers = self.metric.calibration, self.metric.answer_calibration
        if calibration is None:
            return math.exp(-(distance**2))
        same_relation = calibration.same_relation_probability(distance)
        return same_relation if answers is None else answers.probability(same_relation, difference)

    def distances(self, rotations: Tensor, translations: Tensor, *, headings: int = 1) -> Tensor:
        """Metric distances (K,) of K scenes with poses (K, 2, 3, 3) and (K, 2, 3).

        Args:
            rotations: world from object, of base and relative.
            translations: the same, metres from the origin.
            headings: how many the embedding is averaged over: one to search with, the metric's
                own number to report.
        """
        points = apply_poses(self.clouds[None], rotations, translations)
        embeddings = self.metric.embed(points, headings=headings)
        return euclidean_distance(embeddings, self.reference_embedding[None])

    def penalties(
        self, rotations: Tensor, translations: Tensor, *, at_rest: bool = False
    ) -> Tensor:
        """Physical and heading terms (K,), in units of the metric's distance.

        Args:
            rotations: as for the distances.
            translations: likewise.
            at_rest: the scenes were brought to rest: physics, which has nothing to add, is left
                out.
        """
        total = torch.zeros(len(rotations))
        if self.physics_weight > 0.0 and not at_rest:
            total = total + self.physics_weight * self._physics(rotations, translations)
        if self.layout_weight > 0.0:
            total = total + self.layout_weight * self.layout_difference(rotations, translations)
        return total + self.heading_penalty(rotations, translations)

    def layout_difference(self, rotations: Tensor, translations: Tensor) -> Tensor:
        """How far the layout of scenes (K,) is from the demonstration's; a half is another place.

        The metric hardly tells near from far once two objects are next to each other.
        """
        clouds = self.clouds[None, :, ::_LAYOUT_STRIDE]
        layout = Layout.of(apply_poses(clouds, rotations, translations))
        difference: Tensor = layout.difference(self.layout)
        return difference

    def heading_penalty(self, rotations: Tensor, translations: Tensor) -> Tensor:
        """How far scenes (K,) with poses (K, 2, 3, 3), (K, 2, 3) are off the heading to keep."""
        if self.heading is None:
            return torch.zeros(len(translations))
        middles = (rotations @ self.clouds.mean(dim=1)[None, :, :, None])[..., 0] + translations
        offset = (middles[:, 1] - middles[:, 0])[:, :2]
        length = offset.norm(dim=-1).clamp_min(1e-6)
        misalignment = 1.0 - (offset @ self.heading) / length
        # Objects above each other have no heading: the term fades with their offset.
        fade = (length / (0.1 * self.extent)).clamp(max=1.0)
        penalty: Tensor = _HEADING_WEIGHT * misalignment * fade
        return penalty

    def _physics(self, rotations: Tensor, translations: Tensor) -> Tensor:
        surfaces = [torch.from_numpy(shape.points) for shape in self.shapes]
        world = [
            apply_poses(points[None], rotations[:, k], translations[:, k])
            for k, points in enumerate(surfaces)
        ]
        gaps = []
        for k in (0, 1):
            local = (world[k] - translations[:, 1 - k, None]) @ rotations[:, 1 - k]
            gaps.append(self.shapes[1 - k].field.sample(local))
        table = self.table_height - float(self.origin[2])
        heights = [points[..., 2] - table for points in world]
        overlap = sum((-values).clamp_min(0.0).mean(dim=-1) for values in (*gaps, *heights))
        # The relative object should touch the base or the table somewhere.
        nearest = torch.minimum(gaps[0].amin(dim=-1), gaps[1].amin(dim=-1))
        hover = torch.minimum(nearest, heights[1].amin(dim=-1)).clamp_min(0.0)
        return (_PENETRATION_WEIGHT * overlap + _CONTACT_WEIGHT * hover) / self.extent
