"""Hand-made features of a scene: the baseline that a learned metric has to beat.

After Mees et al., "Metric learning for generalizing spatial relations to new objects", IROS 2017.
Over all pairs of a point of the base and one of the relative they count two angles, and of the
nearest pairs the distances: 18 + 18 + 3 numbers. They are not symmetric in the two objects, and do
not change when the whole scene is moved or turned about the vertical.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError, Scene

NUM_ANGLE_BINS = 18
NUM_FEATURES = 2 * NUM_ANGLE_BINS + 3
LEAF_SIZE = 0.03

_CLOSEST_SHARE = 0.01
_NEAR, _FAR = 0.06, 0.20
_DOWN = np.array([0.0, 0.0, -1.0])
_SMALL = 1e-12

FloatArray = NDArray[np.float64]


def scene_features(scene: Scene, *, leaf_size: float = LEAF_SIZE) -> FloatArray:
    """The 39 numbers of a scene.

    Each cloud is thinned in its own frame by :func:`voxel_means`; see :func:`pair_features` for
    the numbers.

    Args:
        scene: base and relative at their poses, z up.
        leaf_size: edge of the voxels, metres; more than the clouds' spacing, since all pairs are
            formed (3 cm gives some hundred points an object).

    Returns:
        (39,) float64.

    Raises:
        ConfigError: for a leaf size that is not positive.
    """
    base, relative = (
        item.world_from_object.apply(voxel_means(item.points, leaf_size)) for item in scene.objects
    )
    return pair_features(base, relative)


def pair_features(base: NDArray[np.floating], relative: NDArray[np.floating]) -> FloatArray:
    """The 39 numbers of two clouds.

    With p1 in the base, p2 in the relative, r = p1 - centroid(base), v = p2 - p1 and g down: a
    histogram of the angle between r and v, and one of the angle between r x g and v x r, in bins
    of 10 degrees from 0 to 180; then, of the closest 1 % of all pairs, the shares at most 6 cm
    apart, up to 20 cm apart and farther. Each histogram, and the shares, sum to one. Pairs whose
    angle is not defined (r = 0, v = 0, r or v vertical) are left out of that histogram.

    Args:
        base: (N, 3), world, metres, z up.
        relative: (M, 3), likewise.

    Returns:
        (39,) float64.
    """
    points = np.asarray(base, dtype=np.float64)
    from_centroid = points - points.mean(axis=0)
    between = np.asarray(relative, dtype=np.float64)[None] - points[:, None]
    distance = np.sqrt(np.einsum('nmi,nmi->nm', between, between))
    # The angle between r x g and v x r is that of two vectors normal to r.
    levelled = np.cross(from_centroid, _DOWN)
    across = np.cross(between, from_centroid[:, None])
    return np.concatenate(
        [
            _angle_histogram(
                np.einsum('ni,nmi->nm', from_centroid, between),
                np.linalg.norm(from_centroid, axis=1)[:, None] * distance,
            ),
            _angle_histogram(
                np.einsum('ni,nmi->nm', levelled, across),
                np.linalg.norm(levelled, axis=1)[:, None]
                * np.sqrt(np.einsum('nmi,nmi->nm', across, across)),
            ),
            _closest_shares(distance.ravel()),
        ]
    )


def voxel_means(points: NDArray[np.floating], leaf_size: float) -> FloatArray:
    """Thins a cloud (N, 3) to the mean of its points in each cube of a grid through the origin.

    Raises:
        ConfigError: for a leaf size that is not positive.
    """
    if not leaf_size > 0.0:
        raise ConfigError(f'the leaf size must be positive, got {leaf_size}')
    points = np.asarray(points, dtype=np.float64)
    cells = np.floor(points / leaf_size).astype(np.int64)
    cells -= cells.min(axis=0)
    sizes = cells.max(axis=0) + 1
    flat = (cells[:, 0] * sizes[1] + cells[:, 1]) * sizes[2] + cells[:, 2]
    _, voxel, count = np.unique(flat, return_inverse=True, return_counts=True)
    sums = [np.bincount(voxel, weights=points[:, axis]) for axis in range(3)]
    return np.stack(sums, axis=1) / count[:, None]


def _angle_histogram(dot: FloatArray, norms: FloatArray) -> FloatArray:
    """Shares (18,) of angles in bins of 10 degrees, from scalar products and norms (N, M)."""
    is_defined = norms > _SMALL
    angle_deg = np.degrees(np.arccos(np.clip(dot[is_defined] / norms[is_defined], -1.0, 1.0)))
    bins = np.minimum((angle_deg * (NUM_ANGLE_BINS / 180.0)).astype(np.int64), NUM_ANGLE_BINS - 1)
    counts = np.bincount(bins, minlength=NUM_ANGLE_BINS).astype(np.float64)
    return counts / max(float(counts.sum()), 1.0)


def _closest_shares(distances: FloatArray) -> FloatArray:
    """Shares (3,) of near, middle and far among the closest 1 % of distances (K,)."""
    count = max(1, int(_CLOSEST_SHARE * len(distances)))
    closest = np.partition(distances, count - 1)[:count]
    near = float(np.mean(closest <= _NEAR))
    far = float(np.mean(closest > _FAR))
    return np.array([near, 1.0 - near - far, far])
