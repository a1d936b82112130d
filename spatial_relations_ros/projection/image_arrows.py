"""Gradients by points as arrows in the images, to be looked at."""

from __future__ import annotations

import torch
from torch import Tensor

from spatial_relations_ros.projection.config import PLANES, ProjectionConfig
from spatial_relations_ros.projection.normalization import fit_unit_cube
from spatial_relations_ros.projection.planes import COLUMN_AXIS, ROW_AXIS, pixel_indices


def image_arrows(points: Tensor, vectors: Tensor, config: ProjectionConfig) -> Tensor:
    """Vectors at points, summed over the points of each pixel, along the image axes.

    Args:
        points: (B, 2, N, 3) world coordinates of (base, relative), metres.
        vectors: (B, 2, N, 3) in the world, gradients for instance.
        config: of the images.

    Returns:
        (B, 3, 2, S, S, 2): along the columns and along the rows of each image, in the world's
        units; 0 where no point falls.
    """
    size = config.image_size
    unit = fit_unit_cube(points, config.margin_px / size)
    pixel_idx = pixel_indices(unit, size)
    parts = []
    for axes in (COLUMN_AXIS, ROW_AXIS):
        along = torch.stack([vectors[..., axes[plane]] for plane in range(len(PLANES))], dim=1)
        image = vectors.new_zeros(*pixel_idx.shape[:3], size * size)
        filled = image.scatter_add_(-1, pixel_idx, along)
        parts.append(filled.view(*filled.shape[:-1], size, size))
    return torch.stack(parts, dim=-1)
