"""The learned metric: Gamma = G_W . rho . psi and the distance of two scenes under it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from spatial_relations_ros.core import Scene
from spatial_relations_ros.learning.answer_calibration import AnswerCalibration
from spatial_relations_ros.learning.calibration import Calibration
from spatial_relations_ros.learning.card import ModelCard
from spatial_relations_ros.learning.encoders import EMBEDDING_DIM, Encoder
from spatial_relations_ros.learning.losses import euclidean_distance
from spatial_relations_ros.projection import image_arrows, project, resample_points

BATCH_SIZE = 64


@dataclass(frozen=True)
class Comparison:
    """Two scenes under a metric; NaN stands where the weights carry no calibration.

    Attributes:
        distance: 0 is equal.
        same_relation_probability: that both show the same relation, where before looking the
            same relation is as likely as another one.
        novelty: of each scene, how far it is from everything that the metric knows; above 1 it
            is novel, and neither distance nor probability mean much.
    """

    distance: float
    same_relation_probability: float
    novelty: tuple[float, float]

    @property
    def is_novel(self) -> tuple[bool, bool]:
        """Whether each scene is unlike everything that the metric was trained with."""
        return self.novelty[0] > 1.0, self.novelty[1] > 1.0


@dataclass(frozen=True, eq=False)
class ProjectionGradients:
    """The gradients of a distance at a scene's six images.

    Attributes:
        images: (3, 2, S, S) of the scene: planes top, front, side; base, relative.
        by_images: (3, 2, S, S) of the distance by the images' values.
        descent: (3, 2, S, S, 2) where the points of each pixel would go to lower the distance:
            minus the gradient by points, summed a pixel, along columns and rows.
    """

    images: NDArray[np.float32]
    by_images: NDArray[np.float32]
    descent: NDArray[np.float32]


class RelationMetric:
    """Embeds scenes; the Euclidean distance of two embeddings says how alike two relations are.

    Not thread-safe: call it from one thread.

    Attributes:
        encoder: the network, in evaluation mode, without gradients to its weights.
        card: where the weights come from.
        calibration: what its distances mean; None for weights without one.
        answer_calibration: how far answers of an imitation can be believed; None likewise.
        num_points: points an object that the network was trained with.
    """

    def __init__(
        self, encoder: Encoder, card: ModelCard, calibration: Calibration | None = None
    ) -> None:
        self.encoder = encoder.eval().requires_grad_(False)
        self._network = encoder.for_inference()
        self._network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        self.card = card
        self.calibration = calibration
        self.answer_calibration = AnswerCalibration.of_card(card.answers)
        self.num_points = card.num_points

    @property
    def embedding_dim(self) -> int:
        """Length of an embedding."""
        return EMBEDDING_DIM

    @property
    def model_hash(self) -> str:
        """SHA-256 of the weights file; embeddings of different models cannot be compared."""
        return self.card.sha256

    @contextmanager
    def projecting(self, **settings: Any) -> Iterator[None]:
        """Other settings of the projection within a ``with`` block, a gradient for instance.

        Args:
            **settings: of :class:`~spatial_relations_ros.projection.ProjectionConfig`. What
                changes the images, as ``gradient='soft'`` does, changes the embeddings: compare
                only those of the same settings.

        Raises:
            ConfigError: for values that make no image.
        """
        usual = self.encoder.projection
        self.encoder.projection = dataclasses.replace(usual, **settings)
        try:
            yield
        finally:
            self.encoder.projection = usual

    def embed(self, points: Tensor, *, headings: int = 1) -> Tensor:
        """Embeddings (B, 64) of world points (B, 2, N, 3); differentiable.

        Args:
            points: scenes.
            headings: how many headings of the whole scene, spread over half a turn, the
                embedding is averaged over. A relation does not depend on the heading; the
                network's images do, and the average is less noisy.
        """
        batch = points.shape[0]
        if headings > 1:
            turns = _about_z(torch.arange(headings) * (math.pi / headings)).to(points.device)
            points = (points[None] @ turns[:, None, None]).flatten(0, 1)
        embeddings: Tensor = self._network(project(points, self.encoder.projection))
        return embeddings.view(headings, batch, -1).mean(dim=0)

    def scene_points(self, scene: Scene) -> NDArray[np.float32]:
        """Points (2, num_points, 3) of base and relative, as the network takes them.

        World axes; the origin is the base object's, so that scenes far from the world's origin
        keep their precision.
        """
        origin = scene.base.world_from_object.translation
        clouds = [
            item.world_from_object.apply(resample_points(item.points, self.num_points)) - origin
            for item in scene.objects
        ]
        return np.stack(clouds).astype(np.float32)

    def embed_scenes(self, scenes: Sequence[Scene]) -> NDArray[np.float32]:
        """Embeddings (B, 64) of scenes, averaged over the card's number of headings."""
        if not scenes:
            return np.zeros((0, self.embedding_dim), dtype=np.float32)
        points = torch.from_numpy(np.stack([self.scene_points(scene) for scene in scenes]))
        with torch.inference_mode():
            chunks = [
                self.embed(chunk, headings=self.card.headings)
                for chunk in torch.split(points, BATCH_SIZE)
            ]
        return torch.cat(chunks).numpy()

    def distance(self, first: Scene, second: Scene) -> float:
        """How unalike two relations are; 0 is equal. The calibration says what more means."""
        return self.compare(first, second).distance

    def compare(self, first: Scene, second: Scene) -> Comparison:
        """The distance of two scenes, what it means, and whether the metric knows such scenes."""
        embeddings = self.embed_scenes([first, second])
        pair = torch.from_numpy(embeddings)
        distance = float(euclidean_distance(pair[0], pair[1]))
        probability = (
            math.nan
            if self.calibration is None
            else self.calibration.same_relation_probability(distance)
        )
        novelty = self.novelty(embeddings)
        return Comparison(distance, probability, (float(novelty[0]), float(novelty[1])))

    def novelty(self, embeddings: NDArray[np.floating]) -> NDArray[np.float64]:
        """How far embeddings (..., D) are from everything known, shape (...).

        Above 1 is novel; NaN for weights without a calibration.
        """
        if self.calibration is None:
            return np.full(np.shape(embeddings)[:-1], math.nan)
        return self.calibration.novelty(embeddings)

    def projection_gradients(self, reference: Scene, test: Scene) -> ProjectionGradients:
        """How the distance to the reference changes with the test scene's images and points."""
        goal = torch.from_numpy(self.embed_scenes([reference]))[0]
        points = torch.from_numpy(self.scene_points(test))[None].requires_grad_(True)
        images = project(points, self.encoder.projection)
        embedding = self._network(images)[0]
        by_images, by_points = torch.autograd.grad(
            euclidean_distance(embedding, goal), (images, points)
        )
        descent = image_arrows(points.detach(), -by_points, self.encoder.projection)
        return ProjectionGradients(
            images[0].detach().numpy(), by_images[0].numpy(), descent[0].numpy()
        )

    def projections(self, scene: Scene) -> NDArray[np.float32]:
        """The network's input (3, 2, S, S): planes top, front, side; base, relative."""
        points = torch.from_numpy(self.scene_points(scene))[None]
        with torch.inference_mode():
            return project(points, self.encoder.projection)[0].numpy()


def _about_z(angles_rad: Tensor) -> Tensor:
    """Rotations (K, 3, 3) about the vertical, for row vectors."""
    cosine, sine = angles_rad.cos(), angles_rad.sin()
    turns = torch.eye(3).repeat(len(angles_rad), 1, 1)
    turns[:, 0, 0], turns[:, 0, 1] = cosine, sine
    turns[:, 1, 0], turns[:, 1, 1] = -sine, cosine
    return turns
