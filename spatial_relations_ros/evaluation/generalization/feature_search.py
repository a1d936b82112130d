"""The baseline of Mees et al. 2017: poses are sampled and compared by hand-made features.

One object stays where it is, as in their paper. Of theirs only the features and the idea are known
here, not how they sample: poses are drawn evenly around the fixed object and in all orientations,
then around the best one with a spread that shrinks. Neither collisions nor balance are asked for.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from spatial_relations_ros.core import Pose
from spatial_relations_ros.evaluation.generalization.attempt import Attempt, Stopwatch
from spatial_relations_ros.evaluation.generalization.cases import Case
from spatial_relations_ros.evaluation.hand_made_features import (
    LEAF_SIZE,
    pair_features,
    scene_features,
    voxel_means,
)

NUM_SAMPLES = 400
NUM_ROUNDS = 5
NUM_A_ROUND = 40

_FIRST_SPREAD = 0.25
_SHRINK = 0.6
_LEAST_VOXELS = 3.0

FloatArray = NDArray[np.float64]


def search_by_features(case: Case, *, seed: int) -> Attempt:
    """Samples poses of the relative around the base; the one with the nearest features wins."""
    watch = Stopwatch()
    search = _Search(case, np.random.default_rng([seed, case.number]))
    pose, distance = search.run()
    return Attempt(
        poses=(case.test.base.world_from_object, pose),
        claimed=None,
        confidence=None,
        distance=distance,
        initial_distance=search.initial_distance,
        num_steps=NUM_SAMPLES + NUM_ROUNDS * NUM_A_ROUND,
        **watch.times(),
    )


class _Search:
    """State of one search."""

    def __init__(self, case: Case, rng: np.random.Generator) -> None:
        self.rng = rng
        test = case.test
        # Small objects would be single voxels: cells are a third of the smallest at most.
        sizes = [float(np.ptp(item.points, axis=0).max()) for item in test.objects]
        leaf_size = min(LEAF_SIZE, min(sizes) / _LEAST_VOXELS)
        self.wanted = scene_features(case.reference, leaf_size=LEAF_SIZE)
        self.base = test.base.world_from_object.apply(voxel_means(test.base.points, leaf_size))
        self.relative = voxel_means(test.relative.points, leaf_size)
        self.middle = self.relative.mean(axis=0)
        self.radius = float(np.linalg.norm(self.relative - self.middle, axis=1).max())
        self.current = test.relative.world_from_object
        self.initial_distance = self._distance(self.current)

    def run(self) -> tuple[Pose, float]:
        """The best pose and its distance."""
        poses = [self._anywhere() for _ in range(NUM_SAMPLES)]
        distances = [self._distance(pose) for pose in poses]
        best = int(np.argmin(distances))
        pose, distance = poses[best], distances[best]
        if self.initial_distance < distance:
            pose, distance = self.current, self.initial_distance
        spread = _FIRST_SPREAD
        for _ in range(NUM_ROUNDS):
            centre = pose
            for _ in range(NUM_A_ROUND):
                candidate = self._near(centre, spread)
                found = self._distance(candidate)
                if found < distance:
                    pose, distance = candidate, found
            spread *= _SHRINK
        return pose, distance

    def _distance(self, pose: Pose) -> float:
        features = pair_features(self.base, pose.apply(self.relative))
        return float(np.linalg.norm(features - self.wanted))

    def _anywhere(self) -> Pose:
        """Any orientation over the table, the middle in the base's box widened by the relative."""
        low = self.base.min(axis=0) - 1.5 * self.radius
        high = self.base.max(axis=0) + 1.5 * self.radius
        rotation = Rotation.random(random_state=self.rng).as_matrix()
        return self._at(rotation, self.rng.uniform(low, high))

    def _near(self, pose: Pose, spread: float) -> Pose:
        """Moved by a share of the relative's size and turned by radians, both normal."""
        turn = Rotation.from_rotvec(self.rng.normal(0.0, spread, 3)).as_matrix()
        middle = pose.apply(self.middle[None])[0]
        shift = self.rng.normal(0.0, spread * self.radius, 3)
        return self._at(turn @ pose.rotation, middle + shift)

    def _at(self, rotation: FloatArray, middle: FloatArray) -> Pose:
        """A pose with the relative's middle at a point, lifted where it would be in the table."""
        lowest = float(((self.relative - self.middle) @ rotation[2]).min()) + middle[2]
        middle = middle + [0.0, 0.0, max(0.0, -lowest)]
        return Pose.from_rotation(rotation, middle - rotation @ self.middle)
