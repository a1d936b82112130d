"""The three image planes: where a point falls and how deep it is."""

from __future__ import annotations

import torch
from torch import Tensor

# World axes (x=0, y=1, z=2) of an image's columns, rows and depth, for each plane. Depth grows
# away from the camera: from the top it is 1 - z.
COLUMN_AXIS = (0, 0, 1)
ROW_AXIS = (1, 2, 2)
DEPTH_AXIS = (2, 1, 0)
DEPTH_SIGN = (-1.0, 1.0, 1.0)
# Which plane looks along a world axis.
PLANE_ALONG = (2, 1, 0)


def pixel_indices(unit: Tensor, size: int) -> Tensor:
    """Flat pixel index (B, 3, 2, N) of each point (B, 2, N, 3) on each plane."""
    pixels = (unit.detach() * size).floor_().clamp_(0, size - 1)
    # Whole numbers of this size are exact as floats.
    return torch.stack(
        [
            torch.add(pixels[..., column], pixels[..., row], alpha=size)
            for column, row in zip(COLUMN_AXIS, ROW_AXIS, strict=True)
        ],
        dim=1,
    ).long()


def depths(unit: Tensor) -> Tensor:
    """Distance (B, 3, 2, N) of each point (B, 2, N, 3) to each image plane."""
    return torch.stack([1.0 - unit[..., 2], unit[..., 1], unit[..., 0]], dim=1)


def columns_and_rows(unit: Tensor, size: int) -> tuple[Tensor, Tensor]:
    """Pixel coordinates (B, 3, 2, N) of each point; whole numbers are centres of pixels."""
    pixels = unit * size - 0.5
    column = torch.stack([pixels[..., axis] for axis in COLUMN_AXIS], dim=1)
    row = torch.stack([pixels[..., axis] for axis in ROW_AXIS], dim=1)
    return column, row
