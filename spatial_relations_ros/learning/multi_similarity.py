"""The multi-similarity loss with mining, over Euclidean distances."""

from __future__ import annotations

from pytorch_metric_learning.distances import LpDistance
from pytorch_metric_learning.losses import MultiSimilarityLoss
from pytorch_metric_learning.miners import MultiSimilarityMiner
from torch import Tensor, nn

# The library's base is made for cosines; distances of alike scenes end up below this one.
_BASE = 0.6
_ALPHA = 2.0
_BETA = 10.0
_MINING_MARGIN = 0.1


class MultiSimilarity(nn.Module):
    """Weighs each pair by how it compares with the other pairs of its anchor.

    Only pairs that are harder than the anchor's easiest pair of the other kind, with a margin,
    are used. Source: Wang et al., "Multi-similarity loss with general pair weighting for deep
    metric learning", CVPR 2019, with the Euclidean distance in place of the cosine, since the
    metric is Euclidean.
    """

    def __init__(self) -> None:
        super().__init__()
        distance = LpDistance(normalize_embeddings=False)
        self.miner = MultiSimilarityMiner(epsilon=_MINING_MARGIN, distance=distance)
        self.loss = MultiSimilarityLoss(alpha=_ALPHA, beta=_BETA, base=_BASE, distance=distance)

    def forward(self, embeddings: Tensor, labels: Tensor) -> Tensor:
        """Scalar loss of embeddings (B, D) with integer classes (B,).

        Zero with a gradient when no pair is left.
        """
        loss: Tensor = self.loss(embeddings, labels, self.miner(embeddings, labels))
        return loss
