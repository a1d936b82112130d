"""Scenes that cannot be, to test whether the metric says that it does not know them."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import Pose, Scene, SceneObject
from spatial_relations_ros.datasets.freiburg import RelationDataset
from spatial_relations_ros.imitation.contact import Body, overlap, reach_through
from spatial_relations_ros.imitation.shape import shape_of

FAR_APART = 1.0
MIN_OVERLAP = 0.01
_MAX_TRIES = 20


def nonsense_scenes(
    dataset: RelationDataset, *, num_each: int, seed: int
) -> Mapping[str, tuple[Scene, ...]]:
    """Real pairs of objects at poses that no relation has.

    Args:
        dataset: whose scenes are spoilt.
        num_each: scenes of each kind.
        seed: of everything random.

    Returns:
        Scenes of three kinds: ``interpenetrating`` (the relative, turned at random, sticks in the
        base or through its wall by a centimetre or more; by less where both are thin),
        ``floating`` (it hangs 5 to 30 cm above the top of the base) and ``far_apart`` (it stands
        1 m beside it, turned at random).
    """
    rng = np.random.default_rng(seed)
    return {
        name: tuple(
            spoil(dataset.scene_of(dataset.scenes[row]), rng)
            for row in rng.choice(len(dataset.scenes), num_each, replace=True)
        )
        for name, spoil in _KINDS.items()
    }


def _interpenetrating(scene: Scene, rng: np.random.Generator) -> Scene:
    low, high = _bounds(scene.base)
    base, relative = (Body(shape_of(item), item.world_from_object) for item in scene.objects)
    deepest, depth = scene, -1.0
    for _ in range(_MAX_TRIES):
        place = low + rng.uniform(0.2, 0.8, 3) * (high - low)
        spoilt = _with_relative(scene, _random_rotation(rng), place)
        moved = Body(relative.shape, spoilt.relative.world_from_object)
        found = max(overlap(base, moved), reach_through(base, moved))
        if found > depth:
            deepest, depth = spoilt, found
        if depth >= MIN_OVERLAP:
            break
    return deepest


def _floating(scene: Scene, rng: np.random.Generator) -> Scene:
    pose = scene.relative.world_from_object
    gap = _bounds(scene.base)[1][2] + rng.uniform(0.05, 0.30) - _bounds(scene.relative)[0][2]
    lifted = Pose(pose.translation + np.array([0.0, 0.0, gap]), pose.quat_wxyz)
    return scene.with_poses(scene.base.world_from_object, lifted)


def _far_apart(scene: Scene, rng: np.random.Generator) -> Scene:
    table = min(_bounds(item)[0][2] for item in scene.objects)
    angle = rng.uniform(0.0, 2.0 * np.pi)
    low, high = _bounds(scene.base)
    place = 0.5 * (low + high) + FAR_APART * np.array([np.cos(angle), np.sin(angle), 0.0])
    spoilt = _with_relative(scene, _random_rotation(rng), place)
    pose = spoilt.relative.world_from_object
    drop = np.array([0.0, 0.0, table - _bounds(spoilt.relative)[0][2]])
    return spoilt.with_poses(
        spoilt.base.world_from_object, Pose(pose.translation + drop, pose.quat_wxyz)
    )


_KINDS: Mapping[str, Callable[[Scene, np.random.Generator], Scene]] = {
    'interpenetrating': _interpenetrating,
    'floating': _floating,
    'far_apart': _far_apart,
}
KINDS = tuple(_KINDS)


def _bounds(item: SceneObject) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lowest and highest corner (3,) of an object's cloud in the world."""
    points = item.world_from_object.apply(item.points)
    return points.min(axis=0), points.max(axis=0)


def _random_rotation(rng: np.random.Generator) -> NDArray[np.float64]:
    """A quaternion, scalar first, uniform over all rotations."""
    quat_wxyz = rng.normal(size=4)
    return np.asarray(quat_wxyz / np.linalg.norm(quat_wxyz))


def _with_relative(
    scene: Scene, quat_wxyz: NDArray[np.float64], place: NDArray[np.float64]
) -> Scene:
    """The relative turned so, the middle of its cloud at a place."""
    turned = Pose(np.zeros(3), quat_wxyz)
    points = turned.apply(scene.relative.points)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return scene.with_poses(scene.base.world_from_object, Pose(place - middle, quat_wxyz))
