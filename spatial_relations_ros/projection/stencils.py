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


def carried_steps(images: Tensor, grad: Tensor) -> Tensor:
    """How the error changes when the content of images moves by one pixel along columns.

    The boundary between two neighbouring pixels carries the step between their values; with the
    mean gradient on both sides this is the change of the error. It is booked on the object's
    pixel, or by halves when both pixels belong to the object.

    Args:
        images: (..., H, W) values, 0 where there is no object.
        grad: (..., H, W) gradient of the error with respect to the images.

    Returns:
        (..., H, W); its sum is the derivative by a common shift in pixels.
    """
    left, right = images[..., :-1], images[..., 1:]
    change = (left - right) * (0.5 * (grad[..., :-1] + grad[..., 1:]))
    is_left, is_right = left > 0, right > 0
    both = is_left & is_right
    booked = torch.zeros_like(images)
    booked[..., :-1] += change * torch.where(both, 0.5, is_left.to(grad.dtype))
    booked[..., 1:] += change * torch.where(both, 0.5, is_right.to(grad.dtype))
    return booked


def box_sum(images: Tensor, side: int) -> Tensor:
    """Sum over a square of ``side`` pixels (odd) around each pixel; zero outside the image."""
    radius = side // 2
    height, width = images.shape[-2:]
    padded = F.pad(images, [radius] * 4)
    rows = padded[..., :height, :].clone()
    for shift in range(1, side):
        rows += padded[..., shift : shift + height, :]
    total = rows[..., :width].clone()
    for shift in range(1, side):
        total += rows[..., shift : shift + width]
    return total


def box_min(images: Tensor, side: int) -> Tensor:
    """Minimum over a square of ``side`` pixels (odd) around each pixel."""
    radius = side // 2
    height, width = images.shape[-2:]
    padded = F.pad(images, [radius] * 4, value=torch.inf)
    rows = padded[..., :height, :]
    for shift in range(1, side):
        rows = torch.minimum(rows, padded[..., shift : shift + height, :])
    least = rows[..., :width]
    for shift in range(1, side):
        least = torch.minimum(least, rows[..., shift : shift + width])
    return least
