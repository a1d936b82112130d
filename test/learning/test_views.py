"""Random views: what a sensor hides and adds."""

import dataclasses

import pytest
import torch

from spatial_relations_ros.learning.training_config import TrainingConfig
from spatial_relations_ros.learning.views import (
    augment,
    random_poses,
    see_from_one_side,
    thin_out,
)
from spatial_relations_ros.projection import resample_points


@pytest.fixture
def points(solids):
    """Four times the same two boxes, one on the other."""
    base = solids.box('base', (0.2, 0.2, 0.1), (0, 0, 0.05))
    relative = solids.box('relative', (0.1, 0.1, 0.1), (0, 0, 0.15))
    clouds = [
        torch.from_numpy(resample_points(item.world_points, 1500)) for item in (base, relative)
    ]
    return torch.stack(clouds).float().expand(4, 2, 1500, 3).contiguous()


def generator(seed=0):
    return torch.Generator().manual_seed(seed)


def nearest(points, others):
    exact = 'donot_use_mm_for_euclid_dist'
    return torch.cdist(points, others, compute_mode=exact).amin(dim=1)


def is_among(view, points):
    """Whether each point of a view (N, 3) is one of the cloud's points (M, 3)."""
    return bool((nearest(view, points) < 1e-6).all())


def inner_underside(points, cloud):
    """Share of points on the inner part of a box's underside."""
    low = points[:, 2] < cloud[:, 2].min() + 1e-4
    inner = (points[:, :2].abs() < 0.8 * cloud[:, :2].abs().max()).all(dim=1)
    return float((low & inner).float().mean())


def test_a_camera_above_sees_tops_and_no_undersides(points):
    seen = see_from_one_side(points, 1.0, generator())
    assert seen.shape == points.shape
    for scene, view in zip(points, seen, strict=True):
        for cloud, visible in zip(scene, view, strict=True):
            assert is_among(visible, cloud)
            # Cells that no nearer point fills leave some of them.
            assert inner_underside(visible, cloud) < 0.7 * inner_underside(cloud, cloud)
            assert (visible[:, 2] > cloud[:, 2].max() - 1e-4).any()


def test_the_upper_object_hides_the_top_under_it(points):
    seen = see_from_one_side(points, 1.0, generator())
    base = points[0, 0]
    top = base[:, 2] > base[:, 2].max() - 1e-4
    covered = top & (base[:, :2].abs() < 0.035).all(dim=1)
    assert covered.sum() > 10
    for view in seen:
        assert (nearest(base[covered], view[0]) < 1e-6).float().mean() < 0.5


def test_a_share_of_zero_changes_nothing(points):
    assert torch.equal(see_from_one_side(points, 0.0, generator()), points)
    assert torch.equal(thin_out(points, 0.0, generator()), points)


def test_thinned_objects_keep_between_a_tenth_and_all_points(points):
    thin = thin_out(points, 1.0, generator(1))
    counts = [len(torch.unique(cloud, dim=0)) for scene in thin for cloud in scene]
    assert 150 <= min(counts) < 1000
    assert max(counts) <= 1500
    assert is_among(thin[0, 0], points[0, 0])


def test_point_noise_stays_within_its_share_of_the_scene(points):
    quiet = TrainingConfig(translation_noise=0.0, rotation_noise_rad=0.0)
    noisy = dataclasses.replace(quiet, point_noise=0.01)
    # The same stream turns both scenes alike before the noise is drawn.
    moved = augment(points, noisy, generator(2)) - augment(points, quiet, generator(2))
    spread = moved.std(dim=(2, 3))
    assert (spread <= 0.01 * 0.21).all()
    assert (spread > 0.0).all()


def test_random_poses_keep_each_shape_and_lose_the_relation(points):
    stray = random_poses(points, generator())
    for old, new in zip(points.flatten(0, 1), stray.flatten(0, 1), strict=True):
        assert torch.allclose(torch.pdist(old[:50]), torch.pdist(new[:50]), atol=1e-5)
    gaps = (stray[:, 1].mean(dim=1) - stray[:, 0].mean(dim=1)).norm(dim=-1)
    assert gaps.std() > 0.01
