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
        (B, 2, N, 3) coordinates between ``margin`` and ``1 - margin``; a view of (B, 3, 2, N).
    """
    # Coordinates apart, (B, 3, 2, N): rows of numbers are several times faster than triples.
    apart = points.permute(0, 3, 1, 2).contiguous()
    low, high = apart.amin(dim=(2, 3)), apart.amax(dim=(2, 3))
    extent = (high - low).amax(dim=1).clamp_min(MIN_EXTENT)
    centre = 0.5 * (low + high)
    scale = (1.0 - 2.0 * margin) / extent
    unit = (apart - centre[:, :, None, None]) * scale[:, None, None, None] + 0.5
    return unit.permute(0, 2, 3, 1)
