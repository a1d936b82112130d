"""Signed distances on a regular grid."""

from __future__ import annotations

from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import Tensor


@dataclass(frozen=True, eq=False)
class DistanceField:
    """Signed distance samples around an object, in its frame.

    Attributes:
        values: (X, Y, Z) metres, negative inside.
        origin: (3,) position of the first node, metres.
        spacing: distance of neighbouring nodes, metres.
    """

    values: Tensor
    origin: Tensor
    spacing: float

    def sample(self, points: Tensor) -> Tensor:
        """Trilinear signed distance (...) at points (..., 3); differentiable.

        Beyond the grid the distance to the grid is added, which is at least the true distance.
        """
        counts = torch.tensor(self.values.shape, dtype=points.dtype, device=points.device)
        node = (points - self.origin) / self.spacing
        clamped = torch.minimum(node.clamp_min(0.0), counts - 1.0)
        # grid_sample wants coordinates from -1 to 1, last axis first.
        unit = (2.0 * clamped / (counts - 1.0) - 1.0).flip(-1).reshape(1, -1, 1, 1, 3)
        inside = F.grid_sample(
            self.values[None, None], unit, mode='bilinear', align_corners=True
        ).reshape(points.shape[:-1])
        beyond = (node - clamped).square().sum(dim=-1)
        is_beyond = beyond > 0.0
        distance = torch.where(is_beyond, beyond, 1.0).sqrt() * self.spacing
        return inside + torch.where(is_beyond, distance, 0.0)
