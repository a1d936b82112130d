"""How far beside each other two objects are, whatever their sizes."""

from __future__ import annotations

import torch
from torch import Tensor

_TINY = 1e-6


def spacing(points: Tensor) -> Tensor:
    """Horizontal distance of two objects' middles over the sum of their half widths, (K,).

    0 where one is in the middle of the other, 1 where they touch side by side, more with a gap;
    widths are taken along the line between the middles.

    Args:
        points: (K, 2, N, 3) clouds of base and relative, any unit, z up.
    """
    flat = points[..., :2]
    middles = 0.5 * (flat.amin(dim=2) + flat.amax(dim=2))
    offset = middles[:, 1] - middles[:, 0]
    distance = offset.norm(dim=-1)
    direction = offset / distance.clamp_min(_TINY)[:, None]
    # Of objects right above each other any line will do.
    centred = (distance < _TINY)[:, None]
    direction = torch.where(centred, torch.tensor([1.0, 0.0]), direction)
    along = (flat * direction[:, None, None]).sum(dim=-1)
    half_widths = 0.5 * (along.amax(dim=2) - along.amin(dim=2)).sum(dim=1)
    return distance / half_widths.clamp_min(_TINY)
