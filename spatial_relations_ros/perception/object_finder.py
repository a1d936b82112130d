"""Looks for each object at its tracked pose in one cloud, with its model or without."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from spatial_relations_ros.core import (
    CloudFormatError,
    CloudSource,
    InvalidSceneError,
    Pose,
    SceneObject,
)
from spatial_relations_ros.perception.beliefs import Beliefs
from spatial_relations_ros.perception.config import PerceptionConfig
from spatial_relations_ros.perception.evidence import judge_rival, judge_support, support_at
from spatial_relations_ros.perception.object_models import KnownModel, ModelSource
from spatial_relations_ros.perception.observed import ObservedObjects
from spatial_relations_ros.perception.refine import PoseRefiner
from spatial_relations_ros.perception.track_state import Evidence, Observation
from spatial_relations_ros.perception.view import View

KnownAt = tuple[KnownModel, Pose]
Seen = tuple[SceneObject | None, Observation]


class ObjectFinder:
    """Makes objects of models and of what is seen, and judges what the cloud says of them.

    Args:
        config: how clouds and poses become objects.
        models: where the objects' models come from.
        beliefs: knows who may have been taken for whom, and is told of looks that have changed.
    """

    def __init__(self, config: PerceptionConfig, models: ModelSource, beliefs: Beliefs) -> None:
        self._config = config
        self._models = models
        self._beliefs = beliefs
        self._refiner = PoseRefiner(config.refine) if config.refine.is_on else None
        self.observed = ObservedObjects(
            config.crop, config.accumulation, tolerance=config.support.tolerance
        )

    def find_models(self, poses: dict[str, Pose]) -> tuple[dict[str, KnownAt], dict[str, str]]:
        """The models of those objects that have one; an object with a bad model is refused.

        Args:
            poses: ``world_from_object`` by id; those with a bad model are taken out.

        Returns:
            Model and pose by id; and why others are refused.
        """
        known: dict[str, KnownAt] = {}
        rejected: dict[str, str] = {}
        for object_id in tuple(poses):
            try:
                model = self._models.find(object_id)
            except CloudFormatError as error:
                rejected[object_id] = f'its model cannot be used: {error}'
                del poses[object_id]
                continue
            if model is not None:
                known[object_id] = model, poses[object_id]
        return known, rejected

    def refine(self, known: dict[str, KnownAt], view: View) -> None:
        """Moves poses to what is seen, where the config asks for it.

        The lowest object comes first: others stand on it.
        """
        if self._refiner is None:
            return
        for object_id in sorted(known, key=lambda key: float(known[key][1].translation[2])):
            model, pose = known[object_id]
            others = [
                known[other_id]
                for other_id in known
                if other_id != object_id and _are_near(pose, known[other_id][1])
            ]
            known[object_id] = model, self._refiner.refined(model, pose, view, others)

    def see(
        self,
        object_id: str,
        poses: Mapping[str, Pose],
        known: Mapping[str, KnownAt],
        view: View,
    ) -> Seen:
        """One object at its pose, and what the cloud says about it.

        Args:
            object_id: which of ``poses``.
            poses: ``world_from_object`` of all objects.
            known: model and pose of those that have a model.
            view: the cloud.

        Returns:
            The object, or None when nothing is seen of it; and the evidence for its pose.
        """
        try:
            if object_id in known:
                return self._from_model(object_id, *known[object_id], view)
            return self._from_cloud(object_id, poses, known, view)
        except InvalidSceneError as error:
            return None, Observation(Evidence.CONTRADICTED, reason=str(error))

    def _from_model(self, object_id: str, model: KnownModel, pose: Pose, view: View) -> Seen:
        config = self._config.support
        support = support_at(model.support_points, pose, view, config.tolerance)
        observation = judge_support(support, view, config)
        rival_id = self._beliefs.rival_of(object_id)
        rival = None if rival_id is None else self._model_of(rival_id)
        if rival_id is not None and rival is not None:
            rival_support = support_at(rival.support_points, pose, view, config.tolerance)
            observation = judge_rival(observation, rival_id, rival_support, config)
        item = SceneObject(object_id, model.points, pose, CloudSource.MODEL, support, model.mesh)
        return item, observation

    def _model_of(self, object_id: str) -> KnownModel | None:
        try:
            return self._models.find(object_id)
        except CloudFormatError:  # said where the object itself is looked for
            return None

    def _from_cloud(
        self,
        object_id: str,
        poses: Mapping[str, Pose],
        known: Mapping[str, KnownAt],
        view: View,
    ) -> Seen:
        pose = poses[object_id]
        sighting = self.observed.see(
            object_id,
            pose,
            view,
            [(model, other) for model, other in known.values() if _are_near(pose, other)],
            [
                other
                for other_id, other in poses.items()
                if other_id not in known and other_id != object_id and _are_near(pose, other)
            ],
        )
        if not sighting.is_consistent:
            self._beliefs.doubt_looks(object_id)
        if sighting.points is None:
            return None, sighting.observation
        item = SceneObject(object_id, sighting.points, pose, CloudSource.OBSERVED)
        return item, sighting.observation


def _are_near(first: Pose, second: Pose) -> bool:
    return bool(np.linalg.norm(first.translation - second.translation) < 1.0)
