"""Losses of distance metric learning."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from spatial_relations_ros.learning.distributed import mean_over_processes

DISTANCE_FLOOR = 1e-6


def euclidean_distance(first: Tensor, second: Tensor) -> Tensor:
    """Distances (...) between embeddings (..., D), with a finite gradient at zero.

    The square root is floored: two identical scenes have distance 1e-6 and gradient zero instead
    of NaN.
    """
    squared = (first - second).square().sum(dim=-1)
    return squared.clamp_min(DISTANCE_FLOOR**2).sqrt()


def triplet_contrastive_loss(
    anchor: Tensor, positive: Tensor, negative: Tensor, margin: float = 1.0
) -> Tensor:
    """Mean of 1/2 d_plus^2 + 1/2 max(0, margin - d_minus)^2 over triplets.

    Source: Jund et al. 2018, equation 4, after Chopra et al. 2005.

    Args:
        anchor: (B, D) embeddings.
        positive: (B, D), similar to the anchor.
        negative: (B, D), dissimilar to the anchor.
        margin: distance beyond which dissimilar scenes no longer count.
    """
    d_plus = euclidean_distance(anchor, positive)
    d_minus = euclidean_distance(anchor, negative)
    loss: Tensor = 0.5 * (d_plus.square() + (margin - d_minus).clamp_min(0.0).square()).mean()
    return loss


def all_pairs_contrastive_loss(
    embeddings: Tensor, labels: Tensor, *, margin: float = 1.0, positive_slack: float = 0.0
) -> Tensor:
    """The same hinge over all pairs of a batch; similar and dissimilar pairs weigh the same.

    Args:
        embeddings: (B, D).
        labels: (B,) integer classes; equal labels are similar.
        margin: distance that dissimilar scenes are pushed to.
        positive_slack: distance below which similar scenes are not drawn closer, which leaves
            room for the continuous differences within a class.

    Returns:
        Scalar; zero with a gradient when the batch has no pair.
    """
    # Not by rows and columns: the gradient of picking rows is summed in any order by two threads.
    distances = euclidean_distance(embeddings[:, None], embeddings[None])
    pair = torch.ones_like(distances, dtype=torch.bool).triu(1)
    distances, similar = distances[pair], (labels[:, None] == labels[None])[pair]
    pull = (distances[similar] - positive_slack).clamp_min(0.0).square()
    push = (margin - distances[~similar]).clamp_min(0.0).square()
    zero = embeddings.sum() * 0.0
    pull_mean = pull.mean() if pull.numel() else zero
    # Averaged over the pairs that still violate the margin: the many easy ones would drown them.
    violating = (push > 0).sum().clamp_min(1)
    push_mean = push.sum() / violating if push.numel() else zero
    return 0.5 * (pull_mean + push_mean)


def neighbourhood_loss(embeddings: Tensor, labels: Tensor, *, temperature: float = 0.3) -> Tensor:
    """Mean of -log P(similar) over all similar pairs, where near scenes are the likely ones.

    Each scene picks another with probability proportional to exp(-d^2 / temperature), as in
    neighbourhood components analysis (Goldberger et al. 2004); the logarithm is averaged over
    pairs as in supervised contrastive learning (Khosla et al. 2020).

    Args:
        embeddings: (B, D).
        labels: (B,) integer classes; equal labels are similar.
        temperature: squared distance that counts as near.

    Returns:
        Scalar; zero with a gradient when no two labels are equal.
    """
    squared = euclidean_distance(embeddings[:, None], embeddings[None]).square()
    itself = torch.eye(len(labels), dtype=torch.bool, device=labels.device)
    logits = (-squared / temperature).masked_fill(itself, -torch.inf)
    log_share = logits - torch.logsumexp(logits, dim=1, keepdim=True)
    similar = (labels[:, None] == labels[None]) & ~itself
    if not similar.any():
        return embeddings.sum() * 0.0
    return -log_share[similar].mean()


def graded_loss(embeddings: Tensor, labels: Tensor, measures: Tensor, *, reach: float) -> Tensor:
    """Holds scenes of a relation apart in proportion to how far their measures are apart.

    Args:
        embeddings: (B, D).
        labels: (B,) integer classes.
        measures: (B, K) continuous ground truth, scaled to about one; NaN where unknown. Only
            measures that both scenes of a pair have are compared.
        reach: distance of scenes whose measures are one unit apart or more.

    Returns:
        Mean of squared differences over pairs of equal labels; zero with a gradient without any.
    """
    row, column = torch.triu_indices(len(labels), len(labels), 1, device=labels.device)
    difference = (measures[row] - measures[column]).square()
    known = ~difference.isnan()
    wanted = reach * difference.nan_to_num(0.0).sum(dim=-1).sqrt().clamp_max(1.0)
    chosen = (labels[row] == labels[column]) & known.any(dim=-1)
    if not chosen.any():
        return embeddings.sum() * 0.0
    distances = euclidean_distance(embeddings[row[chosen]], embeddings[column[chosen]])
    return (distances - wanted[chosen]).square().mean()


class RatioLoss(nn.Module):
    """The triplet loss of the code that the paper's authors released.

    The softmax of both distances, each divided by their running mean, should be (0, 1); its
    squared error is 2 exp(d_plus)^2 / (exp(d_plus) + exp(d_minus))^2. Source: Hoffer and Ailon,
    "Deep metric learning using triplet network", 2015. The softmax is computed without the
    overflow of a plain exp.
    """

    running_mean: Tensor

    def __init__(self, momentum: float = 0.01) -> None:
        """Takes the share of a batch's mean distance in the running mean."""
        super().__init__()
        self.momentum = momentum
        self.register_buffer('running_mean', torch.ones(()))

    def forward(self, anchor: Tensor, positive: Tensor, negative: Tensor) -> Tensor:
        """Mean loss of triplets of embeddings, (B, D) each."""
        d_plus = euclidean_distance(anchor, positive)
        d_minus = euclidean_distance(anchor, negative)
        if self.training:
            mean = mean_over_processes(0.5 * (d_plus + d_minus).detach().mean())
            self.running_mean.lerp_(mean, self.momentum)
        scale = self.running_mean.clamp_min(DISTANCE_FLOOR)
        share = torch.softmax(torch.stack([d_plus, d_minus]) / scale, dim=0)[0]
        return 2.0 * share.square().mean()
