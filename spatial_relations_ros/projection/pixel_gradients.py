"""From the gradient of an error by depth images to its gradient by points.

``silhouette``, ``sobel`` and ``released`` of :mod:`spatial_relations_ros.projection.depth_images`.
"""

from __future__ import annotations

import torch
from torch import Tensor

from spatial_relations_ros.projection.config import (
    DEPTH_SCALE,
    OBJECT_BIAS,
    PLANES,
    ProjectionConfig,
)
from spatial_relations_ros.projection.planes import (
    COLUMN_AXIS,
    DEPTH_AXIS,
    DEPTH_SIGN,
    PLANE_ALONG,
    ROW_AXIS,
)
from spatial_relations_ros.projection.stencils import (
    box_sum,
    carried_steps,
    derivative_kernel,
    slopes,
    sobel_kernel,
)


def shared_gradients(
    grad: Tensor, images: Tensor, pixel_idx: Tensor, config: ProjectionConfig
) -> Tensor:
    """Gradient by points where the points of a pixel share its error: silhouette and sobel.

    Objects are solid: the points whose squares cover a pixel share its error equally, so the sum
    over an object's points is the derivative for moving the object as a whole.

    Args:
        grad: (B, 3, 2, S, S) gradient of the error by the images.
        images: (B, 3, 2, S, S) as projected.
        pixel_idx: (B, 3, 2, N) flat pixel index of each point.
        config: which gradient, and sizes.

    Returns:
        (B, 2, N, 3) error per unit cube.
    """
    size = config.image_size
    counts = torch.zeros(
        *pixel_idx.shape[:3], size * size, dtype=grad.dtype, device=grad.device
    ).scatter_add_(-1, pixel_idx, torch.ones_like(pixel_idx, dtype=grad.dtype))
    shares = box_sum(counts.view_as(images), config.splat_px).clamp_min_(1.0).reciprocal_()
    if config.gradient == 'sobel':
        by_column, by_row = slopes(grad, sobel_kernel(config.sobel_size, dtype=grad.dtype))
        by_column, by_row = by_column * images, by_row * images
    else:
        by_column = carried_steps(images, grad, -1)
        by_row = carried_steps(images, grad, -2)
    by_depth = (images > 0) * grad
    points = grad.new_zeros(grad.shape[0], 3, 2, pixel_idx.shape[-1])
    for by, axes, scales in (
        (by_column, COLUMN_AXIS, (size, size, size)),
        (by_row, ROW_AXIS, (size, size, size)),
        (by_depth, DEPTH_AXIS, [DEPTH_SCALE * sign for sign in DEPTH_SIGN]),
    ):
        by.mul_(shares)
        at_points = box_sum(by, config.splat_px).flatten(-2).gather(-1, pixel_idx)
        for plane in range(len(PLANES)):
            points[:, axes[plane]].add_(at_points[:, plane], alpha=scales[plane])
    return points.permute(0, 2, 3, 1)


def released_gradients(
    grad: Tensor, images: Tensor, pixel_idx: Tensor, depth: Tensor, config: ProjectionConfig
) -> Tensor:
    """Gradient by points as the authors' released code has it.

    The error's slopes along an image axis, by an unscaled kernel d / (dx^2 + dy^2), are summed
    over the occupied pixels of each scan line along that axis. The sum joins the depth gradient
    of the plane that looks along that axis, at all pixels that the scan line's plane meets there;
    the nearest point of a pixel takes it.

    Args:
        grad: (B, 3, 2, S, S) gradient of the error by the images.
        images: (B, 3, 2, S, S) as projected.
        pixel_idx: (B, 3, 2, N) flat pixel index of each point.
        depth: (B, 3, 2, N) of each point.
        config: sizes.

    Returns:
        (B, 2, N, 3) error per unit cube.
    """
    occupied = images > 0
    kernel = derivative_kernel(config.sobel_size, dtype=grad.dtype)
    by_column, by_row = slopes(grad, kernel, border='constant')
    by_column, by_row = by_column * occupied, by_row * occupied
    by_depth = [
        DEPTH_SCALE * DEPTH_SIGN[plane] * grad[:, plane] * occupied[:, plane]
        for plane in range(len(PLANES))
    ]
    for plane in range(len(PLANES)):
        column, row = COLUMN_AXIS[plane], ROW_AXIS[plane]
        along_columns = config.image_size * by_column[:, plane].sum(dim=-1)
        along_rows = config.image_size * by_row[:, plane].sum(dim=-2)
        # What a scan line keeps constant, the other image axis, is an axis there as well.
        for axis, constant, sums in ((column, row, along_columns), (row, column, along_rows)):
            target = PLANE_ALONG[axis]
            dim = -1 if COLUMN_AXIS[target] == constant else -2
            by_depth[target] = by_depth[target] + sums.unsqueeze(-1 if dim == -2 else -2)
    pixels = torch.stack(by_depth, dim=1) * occupied
    at_points = _at_nearest(pixels, images, pixel_idx, depth, config)
    # Plane k looks along axis DEPTH_AXIS[k].
    return torch.stack([at_points[:, PLANE_ALONG[axis]] for axis in range(3)], dim=-1)


def _at_nearest(
    values: Tensor, images: Tensor, pixel_idx: Tensor, depth: Tensor, config: ProjectionConfig
) -> Tensor:
    """Sums pixels' values (B, 3, 2, S, S) at the points that they show, (B, 3, 2, N).

    Points that are equally near share a pixel.
    """
    size, radius = config.image_size, config.splat_px // 2
    offsets = torch.arange(-radius, radius + 1, device=pixel_idx.device)
    row = (pixel_idx // size)[..., None, None] + offsets[:, None]
    column = (pixel_idx % size)[..., None, None] + offsets
    inside = (row >= 0) & (row < size) & (column >= 0) & (column < size)
    window = (row * size + column).where(inside, 0).flatten(3)
    shown = images.flatten(-2).gather(-1, window).view_as(inside)
    own = (DEPTH_SCALE * depth + OBJECT_BIAS)[..., None, None]
    is_shown = (inside & (shown == own)).to(values.dtype).flatten(3)
    counts = values.new_zeros(values.shape[:3] + (size * size,))
    counts.scatter_add_(-1, window, is_shown)
    shares = values.flatten(-2) / counts.clamp_min_(1.0)
    taken = shares.gather(-1, window) * is_shown
    return taken.view(*pixel_idx.shape, -1).sum(dim=-1)
