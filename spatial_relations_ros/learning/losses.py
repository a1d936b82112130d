"""Losses of distance metric learning."""

from __future__ import annotations

import torch
from torch import Tensor

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
    row, column = torch.triu_indices(len(labels), len(labels), 1, device=labels.device)
    distances = euclidean_distance(embeddings[row], embeddings[column])
    similar = labels[row] == labels[column]
    pull = (distances[similar] - positive_slack).clamp_min(0.0).square()
    push = (margin - distances[~similar]).clamp_min(0.0).square()
    zero = embeddings.sum() * 0.0
    pull_mean = pull.mean() if pull.numel() else zero
    # Averaged over the pairs that still violate the margin: the many easy ones would drown them.
    violating = (push > 0).sum().clamp_min(1)
    push_mean = push.sum() / violating if push.numel() else zero
    return 0.5 * (pull_mean + push_mean)
