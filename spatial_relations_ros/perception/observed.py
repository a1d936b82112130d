"""Objects without a model: cut out of each cloud, and remembered over clouds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from spatial_relations_ros.core import Pose
from spatial_relations_ros.perception.accumulation import AccumulatedCloud, AccumulationConfig
from spatial_relations_ros.perception.cropping import CropConfig, crop_object, points_near
from spatial_relations_ros.perception.evidence import support_at
from spatial_relations_ros.perception.object_models import NUM_SUPPORT_POINTS, KnownModel
from spatial_relations_ros.perception.support import looked_through
from spatial_relations_ros.perception.track_state import Evidence, Observation
from spatial_relations_ros.perception.view import View

# With less remembered there is nothing to compare a cloud with.
MIN_REMEMBERED = 40
NOTHING = np.zeros((0, 3), dtype=np.float32)
# A cloud of more points is thinned to one a voxel.
MAX_LIVE_POINTS = 50_000


@dataclass(frozen=True, eq=False)
class Sighting:
    """What one cloud and the memory know of an object.

    Attributes:
        points: (N, 3) float32, object frame; None when nothing is known.
        observation: what the cloud says about the tracked pose.
        is_consistent: False when what is seen is not what was seen at the object before.
    """

    points: NDArray[np.float32] | None
    observation: Observation
    is_consistent: bool = True


class ObservedObjects:
    """Sees objects without a model; remembers what was seen of each.

    Args:
        crop: how objects are cut out.
        accumulation: how much is remembered.
        tolerance: depth difference that is still the same surface, metres.
    """

    def __init__(
        self, crop: CropConfig, accumulation: AccumulationConfig, *, tolerance: float
    ) -> None:
        self._crop, self._accumulation = crop, accumulation
        self._tolerance = tolerance
        self._memory: dict[str, AccumulatedCloud] = {}

    def see(
        self,
        object_id: str,
        pose: Pose,
        view: View,
        models: Sequence[tuple[KnownModel, Pose]],
        rivals: Sequence[Pose],
    ) -> Sighting:
        """One object in one cloud.

        Args:
            object_id: whose memory is used.
            pose: ``world_from_object``, as tracked.
            view: the cloud.
            models: known objects around it with their ``world_from_object``.
            rivals: poses of other objects without a model around it.
        """
        live = self._cut_out(pose, view, models, rivals)
        memory = self._memory.get(object_id)
        remembered = NOTHING if memory is None else memory.points
        is_remembered = len(remembered) >= MIN_REMEMBERED
        consistency = math.nan
        if is_remembered:
            consistency = self._consistency(remembered, live, pose, view)
        if live is None:
            if is_remembered and view.camera is not None and math.isnan(consistency):
                hidden = Observation(Evidence.NONE, reason='its place is hidden or out of view')
                return Sighting(remembered, hidden)
            reason = (
                'there is no model, and nothing of its own is seen within '
                f'{self._crop.radius:.2f} m of the tracked pose'
            )
            return Sighting(None, Observation(Evidence.CONTRADICTED, reason=reason))
        is_consistent = not consistency < self._accumulation.min_consistency
        if memory is None or not is_consistent:
            memory = self._memory[object_id] = AccumulatedCloud(self._accumulation)
        self._forget_what_is_gone(memory, pose, view)
        memory.add(live)
        if len(live) > MAX_LIVE_POINTS:
            points = memory.all_points
        else:
            points = np.concatenate([live, memory.unseen_in(live)])
        return Sighting(points, Observation(Evidence.CONFIRMED), is_consistent)

    def forget(self, object_id: str) -> None:
        """Forgets what was seen of one object."""
        self._memory.pop(object_id, None)

    def keep(self, object_ids: frozenset[str]) -> None:
        """Forgets all other objects."""
        for object_id in self._memory.keys() - object_ids:
            del self._memory[object_id]

    def clear(self) -> None:
        """Forgets everything."""
        self._memory.clear()

    def _cut_out(
        self,
        pose: Pose,
        view: View,
        models: Sequence[tuple[KnownModel, Pose]],
        rivals: Sequence[Pose],
    ) -> NDArray[np.float32] | None:
        centre = view.to_cloud(pose.translation)
        points = crop_object(
            view.to_world(points_near(view.cloud, view.camera, centre, self._crop.radius)),
            pose.translation,
            view.table,
            models,
            [rival.translation for rival in rivals],
            self._crop,
        )
        return None if points is None else pose.inverse().apply(points).astype(np.float32)

    def _consistency(
        self,
        remembered: NDArray[np.float32],
        live: NDArray[np.float32] | None,
        pose: Pose,
        view: View,
    ) -> float:
        """Share of what was seen before that this cloud confirms; NaN when it cannot tell."""
        stride = max(1, len(remembered) // NUM_SUPPORT_POINTS)
        if view.camera is not None:
            return support_at(remembered[::stride], pose, view, self._tolerance)
        if live is None:
            return math.nan
        # Without a camera: how much of what is seen now was there before.
        some = live[:: max(1, len(live) // NUM_SUPPORT_POINTS)]
        distances, _ = cKDTree(remembered).query(some, distance_upper_bound=self._tolerance)
        return float(np.isfinite(distances).mean())

    def _forget_what_is_gone(self, memory: AccumulatedCloud, pose: Pose, view: View) -> None:
        if view.camera is None or not len(memory):
            return
        points = view.to_cloud(pose.apply(memory.all_points))
        memory.miss(looked_through(points, view.cloud, view.camera, tolerance=self._tolerance))
