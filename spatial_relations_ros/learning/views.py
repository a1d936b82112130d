"""Random views of scenes: what a batch shows of them."""

from __future__ import annotations

import math

import roma
import torch
from torch import Tensor

from spatial_relations_ros.learning.training_config import TrainingConfig

_MAX_LIFT = 0.6
_MAX_TILT_RAD = math.radians(60.0)
_LEAST_KEPT = 0.1
_FAR_SHARE, _FAR_REACH = 0.25, 4.0
_VIEW_CELLS = 20
_VIEW_THICKNESS = 0.06
_LOWEST_VIEW_RAD, _HIGHEST_VIEW_RAD = math.radians(15.0), math.radians(70.0)


def augment(points: Tensor, config: TrainingConfig, generator: torch.Generator) -> Tensor:
    """A random view (B, 2, N, 3) of each scene (B, 2, N, 3).

    Noise on both poses, what a sensor adds and hides, rotation of the whole scene about z, and
    the swap of channels, each as far as the configuration asks for it.
    """
    batch = points.shape[0]
    extent = _extents(points.flatten(1, 2)).amax(dim=-1)
    shift = _normal((batch, 2, 1, 3), points, generator) * config.translation_noise
    tilt = _normal((batch, 2, 3), points, generator) * config.rotation_noise_rad
    points = rotate_about_centre(points, tilt) + shift * extent[:, None, None, None]
    yaw = torch.zeros(batch, 3, device=points.device)
    yaw[:, 2] = _uniform((batch,), points, generator) * (2.0 * math.pi)
    points = points @ roma.rotvec_to_rotmat(yaw).transpose(-1, -2)[:, None]
    if config.partial_share > 0.0:
        points = see_from_one_side(points, config.partial_share, generator)
    if config.sparse_share > 0.0:
        points = thin_out(points, config.sparse_share, generator)
    if config.point_noise > 0.0:
        level = _uniform((batch, 2, 1, 1), points, generator) * config.point_noise
        noise = _normal(tuple(points.shape), points, generator)
        points = points + noise * level * extent[:, None, None, None]
    if config.swap_channels:
        swap = _uniform((batch,), points, generator) < 0.5
        points = torch.where(swap[:, None, None, None], points.flip(1), points)
    return points


def thin_out(points: Tensor, share: float, generator: torch.Generator) -> Tensor:
    """Leaves some objects only a tenth to all of their points, which are repeated.

    Args:
        points: (B, 2, N, 3).
        share: of the objects.
        generator: source of the choice.
    """
    batch, _, num_points, _ = points.shape
    kept = _LEAST_KEPT + (1.0 - _LEAST_KEPT) * _uniform((batch, 2), points, generator)
    chosen = _uniform((batch, 2), points, generator) < share
    kept = torch.where(chosen, kept, torch.ones_like(kept))
    count = (kept * num_points).floor().clamp_min(1.0).long()
    idx = torch.arange(num_points, device=points.device) % count[..., None]
    return points.gather(2, idx[..., None].expand_as(points))


def see_from_one_side(points: Tensor, share: float, generator: torch.Generator) -> Tensor:
    """Leaves some objects only the points that a camera above the table sees.

    The camera looks from a random direction, 15 to 70 degrees above the horizon. A coarse depth
    image of both objects decides what is hidden, so one object hides the other as well; what is
    seen is repeated to the number of points.

    Args:
        points: (B, 2, N, 3), z up.
        share: of the objects.
        generator: source of directions and choices.
    """
    batch, _, num_points, _ = points.shape
    azimuth = _uniform((batch,), points, generator) * (2.0 * math.pi)
    span = _HIGHEST_VIEW_RAD - _LOWEST_VIEW_RAD
    height = _LOWEST_VIEW_RAD + span * _uniform((batch,), points, generator)
    zero = torch.zeros_like(azimuth)
    across = torch.stack([-azimuth.sin(), azimuth.cos(), zero], dim=-1)
    ahead = torch.stack(
        [azimuth.cos() * height.cos(), azimuth.sin() * height.cos(), -height.sin()], dim=-1
    )
    camera = torch.stack([across, torch.linalg.cross(ahead, across), ahead], dim=1)
    seen = points.flatten(1, 2) @ camera.transpose(-1, -2)
    low = seen.amin(dim=1, keepdim=True)
    extent = _extents(seen).amax(dim=-1).clamp_min(1e-6)
    unit = (seen - low) / extent[:, None, None]
    cell = (unit[..., :2] * _VIEW_CELLS).long().clamp_(0, _VIEW_CELLS - 1)
    cell_idx = cell[..., 0] * _VIEW_CELLS + cell[..., 1]
    nearest = torch.full((batch, _VIEW_CELLS**2), torch.inf, device=points.device)
    nearest.scatter_reduce_(1, cell_idx, unit[..., 2], reduce='amin')
    visible = unit[..., 2] < nearest.gather(1, cell_idx) + _VIEW_THICKNESS
    visible = visible.view(batch, 2, num_points)
    hides = _uniform((batch, 2), points, generator) < share
    hides &= visible.sum(dim=-1) >= 8
    visible |= ~hides[..., None]
    # Visible points first, in their order; the rest of the row repeats them.
    order = (~visible).to(torch.int8).argsort(dim=-1, stable=True)
    count = visible.sum(dim=-1, keepdim=True)
    idx = order.gather(-1, torch.arange(num_points, device=points.device) % count)
    return points.gather(2, idx[..., None].expand_as(points))


def lift_and_tilt(points: Tensor, generator: torch.Generator) -> tuple[Tensor, Tensor]:
    """Scenes whose relative object is lifted, sunk or tilted, and by how much.

    Such a scene has lost its relation to the degree of the change, whatever the relation was.

    Args:
        points: (B, 2, N, 3) real scenes.
        generator: source of the changes.

    Returns:
        The changed points and the change (B,), 0 (none) to 1 (as far as it goes).
    """
    batch = points.shape[0]
    amount = _uniform((batch,), points, generator)
    sign = torch.where(_uniform((batch,), points, generator) < 0.5, -1.0, 1.0)
    is_lift = (_uniform((batch,), points, generator) < 0.6).to(points.dtype)
    direction = _uniform((batch,), points, generator) * (2.0 * math.pi)
    relative = points[:, 1:]
    height = _extents(relative[:, 0]).mean(dim=-1)
    angle = (1.0 - is_lift) * amount * _MAX_TILT_RAD
    axis = torch.stack([direction.cos(), direction.sin(), torch.zeros_like(angle)], dim=-1)
    relative = rotate_about_centre(relative, (axis * angle[:, None])[:, None])
    lift = torch.zeros(batch, 1, 1, 3, device=points.device)
    lift[..., 2] = (is_lift * sign * amount * _MAX_LIFT * height)[:, None, None]
    return torch.cat([points[:, :1], relative + lift], dim=1), amount


def random_poses(points: Tensor, generator: torch.Generator) -> Tensor:
    """Scenes (B, 2, N, 3) whose objects are turned at random, the relative one anywhere.

    It is up to the scene's extent away from the base, or, in a quarter of them, four times as far.
    """
    batch = points.shape[0]
    turns = roma.unitquat_to_rotvec(
        torch.nn.functional.normalize(_normal((batch, 2, 4), points, generator), dim=-1)
    )
    turned = rotate_about_centre(points, turns)
    reach = _extents(points.flatten(1, 2)).amax(dim=-1)
    is_far = _uniform((batch,), points, generator) < _FAR_SHARE
    reach = torch.where(is_far, _FAR_REACH * reach, reach)
    direction = _uniform((batch, 1, 1, 3), points, generator) * 2.0 - 1.0
    offset = direction * reach[:, None, None, None]
    middle = turned.amin(dim=2, keepdim=True) + turned.amax(dim=2, keepdim=True)
    towards_base = 0.5 * (middle[:, :1] - middle[:, 1:])
    return torch.cat([turned[:, :1], turned[:, 1:] + towards_base + offset], dim=1)


def rotate_about_centre(points: Tensor, rotvec: Tensor) -> Tensor:
    """Turns clouds (B, K, N, 3) by vectors (B, K, 3) about their bounding boxes' centres."""
    centre = 0.5 * (points.amax(dim=-2, keepdim=True) + points.amin(dim=-2, keepdim=True))
    rotations: Tensor = roma.rotvec_to_rotmat(rotvec)
    return (points - centre) @ rotations.transpose(-1, -2) + centre


def _extents(points: Tensor) -> Tensor:
    return points.amax(dim=-2) - points.amin(dim=-2)


def _uniform(shape: tuple[int, ...], like: Tensor, generator: torch.Generator) -> Tensor:
    """Drawn where the generator lives, so that every device gets the same numbers."""
    return torch.rand(shape, generator=generator).to(like.device)


def _normal(shape: tuple[int, ...], like: Tensor, generator: torch.Generator) -> Tensor:
    return torch.randn(shape, generator=generator).to(like.device)
