"""rho: three orthogonal depth images of a scene, with gradients that know where a pixel is.

Source: Jund et al., "Optimization Beyond the Convolution", ICRA 2018, section III. The forward
pass is the paper's. The derivative of a depth image as such is blind to motion along the image
axes, so the backward pass replaces it. Two kinds are there, both scaled so that their sum over an
object's points is the derivative for moving the object as a whole:

``sobel``, the paper's: the gradient U' of the error with respect to an image, convolved with a
Sobel-derived kernel, says how the error changes when a pixel moves along the image axes; a pixel
of value v that moves by one pixel changes the error by v times the slope of U'. Exact for an
image that shifts; blind to most of a rotation, which moves the two sides of an object apart.

``silhouette``, ours: when an object moves, the boundary between two neighbouring pixels carries
the step of their values across it. The error changes by that step times U' there, and the change
belongs to the points at that boundary, so a rotation is seen as well as a shift.
"""

from __future__ import annotations

from typing import Any

import torch
from torch import Tensor

from spatial_relations_ros.projection.config import (
    DEPTH_SCALE,
    OBJECT_BIAS,
    PLANES,
    ProjectionConfig,
)
from spatial_relations_ros.projection.normalization import fit_unit_cube
from spatial_relations_ros.projection.stencils import (
    box_min,
    box_sum,
    carried_steps,
    slopes,
    sobel_kernel,
)

# World axes (x=0, y=1, z=2) of an image's columns, rows and depth, for each plane. Depth grows
# away from the camera: from the top it is 1 - z.
_COLUMN_AXIS = (0, 0, 1)
_ROW_AXIS = (1, 2, 2)
_DEPTH_AXIS = (2, 1, 0)
_DEPTH_SIGN = (-1.0, 1.0, 1.0)


def project(points: Tensor, config: ProjectionConfig) -> Tensor:
    """Depth images of scenes: rho with the gradient that the configuration names.

    Args:
        points: (B, 2, N, 3) world coordinates of (base, relative), metres, z up.
        config: image size, margin, splat and kernel sizes.

    Returns:
        (B, 3, 2, S, S): planes top, front, side; channels base, relative; an empty pixel is 0,
        others are 100 + 100 times the distance to the image plane in the unit cube. Columns grow
        along x, x, y and rows along y, z, z.
    """
    unit = fit_unit_cube(points, config.margin_px / config.image_size)
    images: Tensor = _Projection.apply(unit, config)  # type: ignore[no-untyped-call]
    return images


class _Projection(torch.autograd.Function):
    """Unit-cube points to depth images; see the module's docstring for the backward passes."""

    @staticmethod
    def forward(ctx: Any, unit: Tensor, config: ProjectionConfig) -> Tensor:
        pixel_idx = _pixel_indices(unit, config.image_size)
        depth = _depths(unit)
        images = _scatter_depth(pixel_idx, depth, config)
        ctx.save_for_backward(pixel_idx, images)
        ctx.config = config
        return images

    @staticmethod
    def backward(ctx: Any, *grad_outputs: Tensor) -> tuple[Tensor, None]:
        pixel_idx, images = ctx.saved_tensors
        config: ProjectionConfig = ctx.config
        shares = _shared_pixel_gradients(grad_outputs[0], images, pixel_idx, config)
        return _points_from_pixels(shares, pixel_idx), None


def _pixel_indices(unit: Tensor, size: int) -> Tensor:
    """Flat pixel index (B, 3, 2, N) of each point on each plane."""
    pixels = (unit.detach() * size).floor().clamp_(0, size - 1).long()
    column = torch.stack([pixels[..., axis] for axis in _COLUMN_AXIS], dim=1)
    row = torch.stack([pixels[..., axis] for axis in _ROW_AXIS], dim=1)
    return row * size + column


def _depths(unit: Tensor) -> Tensor:
    """Distance (B, 3, 2, N) of each point to each image plane."""
    return torch.stack([1.0 - unit[..., 2], unit[..., 1], unit[..., 0]], dim=1).detach()


def _scatter_depth(pixel_idx: Tensor, depth: Tensor, config: ProjectionConfig) -> Tensor:
    size = config.image_size
    shape = (*pixel_idx.shape[:3], size * size)
    nearest = torch.full(shape, torch.inf, dtype=depth.dtype, device=depth.device)
    nearest.scatter_reduce_(-1, pixel_idx, depth, reduce='amin')
    nearest = nearest.view(*shape[:3], size, size)
    if config.splat_px > 1:
        nearest = box_min(nearest, config.splat_px)
    return torch.where(torch.isinf(nearest), 0.0, DEPTH_SCALE * nearest + OBJECT_BIAS)


def _shared_pixel_gradients(
    grad: Tensor, images: Tensor, pixel_idx: Tensor, config: ProjectionConfig
) -> Tensor:
    """Derivatives of the error by column, row and depth, for one point of each pixel.

    Objects are solid: the points whose squares cover a pixel share its error equally, so the sum
    over an object's points is the derivative for moving the object as a whole.

    Returns:
        (B, 3, 2, 3, S * S) in units of error per unit cube.
    """
    size = config.image_size
    counts = torch.zeros(
        *pixel_idx.shape[:3], size * size, dtype=grad.dtype, device=grad.device
    ).scatter_add_(-1, pixel_idx, torch.ones_like(pixel_idx, dtype=grad.dtype))
    counts = box_sum(counts.view_as(images), config.splat_px).clamp_min_(1.0)
    if config.gradient == 'sobel':
        by_column, by_row = slopes(grad, sobel_kernel(config.sobel_size, dtype=grad.dtype))
        by_column, by_row = by_column * images, by_row * images
    else:
        by_column = carried_steps(images, grad)
        by_row = carried_steps(images.mT, grad.mT).mT
    by_depth = (images > 0).to(grad.dtype) * grad * DEPTH_SCALE
    moves = torch.stack([by_column * size, by_row * size, by_depth], dim=3) / counts[:, :, :, None]
    return box_sum(moves, config.splat_px).flatten(-2)


def _points_from_pixels(shares: Tensor, pixel_idx: Tensor) -> Tensor:
    """Sums the three planes' pixel derivatives at each point, (B, 2, N, 3)."""
    index = pixel_idx[:, :, :, None, :].expand(-1, -1, -1, 3, -1)
    at_points = shares.gather(-1, index)
    grad = at_points.new_zeros(*at_points.shape[:1], 2, at_points.shape[-1], 3)
    for plane in range(len(PLANES)):
        grad[..., _COLUMN_AXIS[plane]] += at_points[:, plane, :, 0]
        grad[..., _ROW_AXIS[plane]] += at_points[:, plane, :, 1]
        grad[..., _DEPTH_AXIS[plane]] += _DEPTH_SIGN[plane] * at_points[:, plane, :, 2]
    return grad
