"""Scaling a scene to the unit cube."""

from __future__ import annotations

import torch

MIN_EXTENT = 1e-6


def fit_unit_cube(points: torch.Tensor, margin: float) -> torch.Tensor:
    """Centres and scales whole scenes uniformly so that they fit the unit cube.

    Differentiable, through the scene's extent and centre as well, so a common shift of both
    objects has no gradient and a change of one object's place is felt by the other's image.

    Args:
        points: (B, 2, N, 3) world coordinates, metres.
        margin: free share of the cube on every side, 0 to below 0.5.

    Returns:
        (B, 2, N, 3) coordinates between ``margin`` and ``1 - margin``.
    """
    flat = points.flatten(1, 2)
    low, high = flat.amin(dim=1), flat.amax(dim=1)
    extent = (high - low).amax(dim=1).clamp_min(MIN_EXTENT)
    centre = 0.5 * (low + high)
    scale = (1.0 - 2.0 * margin) / extent
    return (points - centre[:, None, None, :]) * scale[:, None, None, None] + 0.5
