"""Drawing a batch and computing its loss."""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor, nn

from spatial_relations_ros.learning.encoders import make_encoder
from spatial_relations_ros.learning.losses import (
    RatioLoss,
    all_pairs_contrastive_loss,
    euclidean_distance,
    graded_loss,
    neighbourhood_loss,
    triplet_contrastive_loss,
)
from spatial_relations_ros.learning.multi_similarity import MultiSimilarity
from spatial_relations_ros.learning.training_config import TrainingConfig
from spatial_relations_ros.learning.training_set import TrainingSet
from spatial_relations_ros.learning.views import augment, lift_and_tilt, random_poses
from spatial_relations_ros.projection import project

Embed = Callable[[Tensor], Tensor]


class BatchLoss(nn.Module):
    """The loss that a configuration asks for; a module, since some losses keep a state."""

    def __init__(self, config: TrainingConfig) -> None:
        super().__init__()
        self.config = config
        self.projection = make_encoder(config.encoder).projection
        self.ratio = RatioLoss()
        self.multi_similarity = MultiSimilarity()

    def forward(
        self, training_set: TrainingSet, embed: Embed, generator: torch.Generator
    ) -> Tensor:
        """The loss of a freshly drawn batch.

        Args:
            training_set: where scenes are drawn from.
            embed: images (B, 3, 2, S, S) to embeddings (B, D), all of a batch at once.
            generator: source of scenes, points and views.
        """
        config = self.config
        rows = training_set.draw_scenes(config.scenes_per_class, generator)
        points = training_set.points(rows, config.num_points, generator)
        labels = training_set.labels[rows]
        batch = len(rows)
        order = torch.randperm(batch, generator=generator).to(points.device)
        clones = order[: config.lifted_clones]
        lifted, change = lift_and_tilt(points[clones], generator)
        strays = order[: round(config.random_negatives * batch)]
        stray = random_poses(points[strays], generator)
        points = augment(torch.cat([points, lifted, stray]), config, generator)
        embeddings = embed(project(points, self.projection))
        sizes = [batch, len(clones), len(strays)]
        scenes, of_lifted, of_stray = torch.split(embeddings, sizes)
        loss = self._class_loss(scenes, labels, of_stray, generator)
        if len(clones):
            distances = euclidean_distance(scenes[clones], of_lifted)
            loss = loss + config.lifted_weight * (distances - change).square().mean()
        if config.graded_weight:
            measures = training_set.measures[rows]
            graded = graded_loss(scenes, labels, measures, reach=config.graded_reach)
            loss = loss + config.graded_weight * graded
        return loss

    def _class_loss(
        self, embeddings: Tensor, labels: Tensor, strays: Tensor, generator: torch.Generator
    ) -> Tensor:
        name = self.config.loss
        if name in ('all_pairs', 'neighbourhood', 'multi_similarity'):
            # Scenes at random poses are like nothing else, not even like each other.
            alone = -1 - torch.arange(len(strays), device=labels.device)
            everything, classes = torch.cat([embeddings, strays]), torch.cat([labels, alone])
            if name == 'all_pairs':
                return all_pairs_contrastive_loss(everything, classes)
            if name == 'multi_similarity':
                of_pairs: Tensor = self.multi_similarity(everything, classes)
                return of_pairs
            return neighbourhood_loss(everything, classes)
        positive, negative = _triplets(labels, generator)
        anchor, others = embeddings, embeddings[negative]
        if len(strays):
            # A scene at random poses is unlike any relation.
            chosen = torch.randperm(len(labels), generator=generator)[: len(strays)]
            others = others.index_copy(0, chosen.to(others.device), strays)
        if name == 'ratio':
            ratio: Tensor = self.ratio(anchor, embeddings[positive], others)
            return ratio
        return triplet_contrastive_loss(anchor, embeddings[positive], others)


def _triplets(labels: Tensor, generator: torch.Generator) -> tuple[Tensor, Tensor]:
    """For each scene of a batch (B,), the rows of a similar and of a dissimilar one."""
    labels = labels.cpu()
    similar = labels[:, None] == labels[None]
    others = similar & ~torch.eye(len(labels), dtype=torch.bool)
    positive = torch.multinomial(others.float(), 1, generator=generator)[:, 0]
    negative = torch.multinomial((~similar).float(), 1, generator=generator)[:, 0]
    return positive, negative
