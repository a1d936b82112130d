"""A soft projection: smooth in the points, so that its derivative is exact.

Every point is a square with blurred borders, as wide as the hard projection's squares. A pixel is
covered by the share 1 - exp(-k D) that grows with the density D of the squares over it, and its
depth is the soft minimum of theirs: their mean, weighted by exp(-depth / tau). The blur decides
from how far away a point feels a pixel. After the soft rasterisers of meshes (Liu et al., "Soft
Rasterizer", ICCV 2019) and of points (Insafutdinov and Dosovitskiy, NeurIPS 2018).
"""

from __future__ import annotations

import math

import torch
from torch import Tensor

from spatial_relations_ros.projection.config import (
    DEPTH_SCALE,
    OBJECT_BIAS,
    ProjectionConfig,
)
from spatial_relations_ros.projection.planes import columns_and_rows, depths

# Depths that lie within this share of the cube count as equally near.
_DEPTH_SOFTNESS = 0.02
# Coverage is 1 - exp(-3) = 95 % where squares lie as densely as they do on average.
_SATURATION = 3.0
# Where a blurred square ends; what is fainter is rounding.
_SPREAD_END = 1e-4
_LEAST_WEIGHT = 1e-30


def soft_images(unit: Tensor, config: ProjectionConfig) -> Tensor:
    """Soft depth images of scenes in the unit cube; differentiable by autograd.

    Args:
        unit: (B, 2, N, 3) points in the unit cube.
        config: image size, splat and ``soft_width_px``.

    Returns:
        (B, 3, 2, S, S), values as :func:`~spatial_relations_ros.projection.project` gives them,
        smaller where a pixel is covered in part.
    """
    depth = depths(unit)
    nearness = torch.exp((depth.detach().amin(dim=-1, keepdim=True) - depth) / _DEPTH_SOFTNESS)
    fields = torch.stack([torch.ones_like(depth), nearness, nearness * depth], dim=3)
    column, row = columns_and_rows(unit, config.image_size)
    spread = _spread_matrix(config, unit.dtype, unit.device)
    density, weight, weighted = (spread @ _scatter(fields, column, row, config) @ spread).unbind(3)
    # The density that a covered pixel has on average, weighted by itself: a pixel of solid cover.
    solid = (density**2).sum(dim=(-2, -1)) / density.sum(dim=(-2, -1)).clamp_min(_LEAST_WEIGHT)
    thickness = density / solid[..., None, None].clamp_min(_LEAST_WEIGHT)
    coverage = -torch.expm1(-_SATURATION * thickness)
    nearest = weighted / weight.clamp_min(_LEAST_WEIGHT)
    return coverage * (DEPTH_SCALE * nearest + OBJECT_BIAS)


def _scatter(fields: Tensor, column: Tensor, row: Tensor, config: ProjectionConfig) -> Tensor:
    """Books fields (B, 3, 2, F, N) of points on their four nearest pixels, (B, 3, 2, F, S, S)."""
    size = config.image_size
    left = column.detach().floor().clamp(0, size - 2)
    above = row.detach().floor().clamp(0, size - 2)
    right_share = (column - left).clamp(0.0, 1.0)
    below_share = (row - above).clamp(0.0, 1.0)
    corner = (above * size + left).long()
    corners = torch.cat([corner, corner + 1, corner + size, corner + size + 1], dim=-1)
    across = torch.cat([1.0 - right_share, right_share], dim=-1)
    shares = torch.cat(
        [across * torch.cat([1.0 - below_share] * 2, dim=-1),
         across * torch.cat([below_share] * 2, dim=-1)], dim=-1,
    )  # fmt: skip
    values = fields.repeat(1, 1, 1, 1, 4) * shares[:, :, :, None]
    index = corners[:, :, :, None].expand_as(values)
    images = values.new_zeros(*values.shape[:-1], size * size).scatter_add(-1, index, values)
    return images.view(*values.shape[:-1], size, size)


def _spread_matrix(config: ProjectionConfig, dtype: torch.dtype, device: torch.device) -> Tensor:
    """Symmetric (S, S): a square of ``splat_px``, its borders blurred by a Gaussian."""
    ticks = torch.arange(config.image_size, dtype=dtype, device=device)
    offset = (ticks[:, None] - ticks[None, :]).abs()
    half, width = 0.5 * config.splat_px, math.sqrt(2.0) * config.soft_width_px
    spread = 0.5 * (torch.erf((offset + half) / width) - torch.erf((offset - half) / width))
    return torch.where(spread < _SPREAD_END, 0.0, spread)


def coarse_to_fine(progress: float, *, coarse_px: float = 2.0, fine_px: float = 0.5) -> float:
    """Width of the blur, in pixels, that shrinks by equal ratios over an optimisation.

    Args:
        progress: share of the steps that are done, 0 to 1.
        coarse_px: width at the start.
        fine_px: width at the end.
    """
    return coarse_px * math.pow(fine_px / coarse_px, min(max(progress, 0.0), 1.0))
