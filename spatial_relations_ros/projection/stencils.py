"""Small image stencils as sums of shifted images.

On a CPU these are several times faster than the general convolutions and pools of torch for
images of one channel.
"""

from __future__ import annotations

import torch
import torch.nn.functional as F
from torch import Tensor


def derivative_kernel(size: int, *, dtype: torch.dtype = torch.float32) -> Tensor:
    """Derivative kernel (size, size) along columns, entries dx / (dx^2 + dy^2).

    Larger kernels than 3 carry the sparse gradients behind max pooling further (Jund et al. 2018,
    section III-B).
    """
    offsets = torch.arange(size, dtype=dtype) - size // 2
    dy, dx = torch.meshgrid(offsets, offsets, indexing='ij')
    squared = (dx**2 + dy**2).clamp_min(1.0)
    return dx / squared


def sobel_kernel(size: int, *, dtype: torch.dtype = torch.float32) -> Tensor:
    """:func:`derivative_kernel`, scaled so that correlation with a ramp of slope one gives one."""
    kernel = derivative_kernel(size, dtype=dtype)
    ramp = torch.arange(size, dtype=dtype) - size // 2
    return kernel / (kernel * ramp).sum()


def slopes(images: Tensor, kernel: Tensor, *, border: str = 'replicate') -> tuple[Tensor, Tensor]:
    """Correlates images (..., H, W) with a derivative kernel along columns and along rows.

    Args:
        images: what to differentiate.
        kernel: odd in its column offset and even in its row offset, as :func:`sobel_kernel` is.
        border: what lies outside an image: its last pixel (``replicate``) or zero (``constant``).
    """
    radius = len(kernel) // 2
    flat = images.reshape(-1, 1, *images.shape[-2:])
    padded = F.pad(flat, [radius] * 4, mode=border)[:, 0]
    along_columns = _odd_correlation(padded, kernel)
    along_rows = _odd_correlation(padded.transpose(-1, -2), kernel).transpose(-1, -2)
    return along_columns.reshape(images.shape), along_rows.reshape(images.shape)


def _odd_correlation(padded: Tensor, kernel: Tensor) -> Tensor:
    radius = len(kernel) // 2
    height, width = padded.shape[-2] - 2 * radius, padded.shape[-1] - 2 * radius
    total = torch.zeros_like(padded[..., :height, :width])
    for dx in range(1, radius + 1):
        right = padded[..., radius + dx : radius + dx + width]
        left = padded[..., radius - dx : radius - dx + width]
        difference = right - left
        for row, weight in enumerate(kernel[:, radius + dx].tolist()):
            total.add_(difference[..., row : row + height, :], alpha=weight)
    return total


def carried_steps(images: Tensor, grad: Tensor, dim: int) -> Tensor:
    """How the error changes when the content of images moves by one pixel along a dimension.

    The boundary between two neighbouring pixels carries the step between their values; with the
    mean gradient on both sides this is the change of the error. It is booked on the object's
    pixel, or by halves when both pixels belong to the object.

    Args:
        images: (..., H, W) values, 0 where there is no object.
        grad: (..., H, W) gradient of the error with respect to the images.
        dim: -1 for motion along columns' numbers, -2 along rows'.

    Returns:
        (..., H, W); its sum is the derivative by a common shift in pixels.
    """
    pairs = images.shape[dim] - 1
    before, after = images.narrow(dim, 0, pairs), images.narrow(dim, 1, pairs)
    change = (before - after).mul_(grad.narrow(dim, 0, pairs) + grad.narrow(dim, 1, pairs))
    covered = (images > 0).to(grad.dtype)
    is_before, is_after = covered.narrow(dim, 0, pairs), covered.narrow(dim, 1, pairs)
    # Half of the change, since the gradients were added; a quarter where both are the object.
    booked = torch.zeros_like(images)
    booked.narrow(dim, 0, pairs).add_((0.5 - 0.25 * is_after).mul_(is_before).mul_(change))
    booked.narrow(dim, 1, pairs).add_((0.5 - 0.25 * is_before).mul_(is_after).mul_(change))
    return booked


def box_sum(images: Tensor, side: int) -> Tensor:
    """Sum over a square of ``side`` pixels (odd) around each pixel; zero outside the image."""
    for dim in (-2, -1):
        total = images.clone()
        for shift, rest in _shifts(images.shape[dim], side):
            total.narrow(dim, shift, rest).add_(images.narrow(dim, 0, rest))
            total.narrow(dim, 0, rest).add_(images.narrow(dim, shift, rest))
        images = total
    return images


def box_min(images: Tensor, side: int) -> Tensor:
    """Minimum over a square of ``side`` pixels (odd) around each pixel."""
    for dim in (-2, -1):
        least = images.clone()
        for shift, rest in _shifts(images.shape[dim], side):
            later, earlier = least.narrow(dim, shift, rest), least.narrow(dim, 0, rest)
            torch.minimum(later, images.narrow(dim, 0, rest), out=later)
            torch.minimum(earlier, images.narrow(dim, shift, rest), out=earlier)
        images = least
    return images


def _shifts(length: int, side: int) -> list[tuple[int, int]]:
    """By how many pixels to shift for a window of ``side``, and how many pixels then overlap."""
    return [(shift, length - shift) for shift in range(1, min(side // 2, length - 1) + 1)]
