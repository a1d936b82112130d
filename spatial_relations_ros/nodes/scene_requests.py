"""Which scenes an imitation request means."""

from __future__ import annotations

import dataclasses
from typing import Any

from spatial_relations_msgs.srv import Recall

from spatial_relations_ros.core import (
    CloudSource,
    InvalidSceneError,
    Scene,
    SceneObject,
    UnknownRelationError,
)
from spatial_relations_ros.nodes.perception_parameters import model_source
from spatial_relations_ros.nodes.scene_client import SceneClient, SeenScene, call
from spatial_relations_ros.perception.object_models import ModelSource
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.conversions import scene_from_msg
from spatial_relations_ros.ros.relations_node import RelationsNode


class SceneRequests:
    """Resolves reference and test of requests.

    Ids are asked of perception, names of the metric node's memory. Objects that are seen get the
    surface of their model, where it is known.
    """

    def __init__(self, node: RelationsNode, scenes: SceneClient) -> None:
        """Reads the parameters ``metric`` and ``models_path`` of the node.

        Raises:
            ConfigError: when the models' folder does not exist.
        """
        self._node, self._scenes = node, scenes
        self._models = model_source(node.parameters.text('models_path'))
        self._recall = node.create_client(
            Recall,
            f'{node.parameters.text("metric")}/recall',
            qos_profile=qos.REQUESTS,
            callback_group=node.requests_group,
        )

    def resolve(self, request: Any, *, with_others: bool) -> tuple[Scene, SeenScene]:
        """Reference and test of an Imitate request or an ImitateRelation goal.

        Args:
            request: the message.
            with_others: whether the test comes with what else is seen, when it is seen itself.

        Raises:
            InvalidSceneError: when a scene is given twice or not at all.
            UnknownObjectError: when an object is not seen.
            UnknownRelationError: when a name is not remembered.
            NoAnswerError: when another node does not answer.
        """
        reference = self._reference(request)
        test = self._scenes.given_or_seen(
            request.test_scene, request.test_ids, what='test', with_others=with_others
        )
        if request.test_ids:
            test = dataclasses.replace(
                test,
                scene=with_meshes(test.scene, self._models),
                others=tuple(with_mesh(item, self._models) for item in test.others),
            )
        return reference, test

    def _reference(self, request: Any) -> Scene:
        if not request.reference_name:
            return self._scenes.given_or_seen(
                request.reference_scene, request.reference_ids, what='reference'
            ).scene
        if request.reference_ids or request.reference_scene:
            raise InvalidSceneError('reference: give a name, object ids or a scene, only one')
        response = call(self._node, self._recall, Recall.Request(name=request.reference_name))
        if not response.success:
            raise UnknownRelationError(response.message)
        return scene_from_msg(response.scene)


def with_meshes(scene: Scene, models: ModelSource) -> Scene:
    """The scene with the surfaces of those objects whose cloud is their model's."""
    base, relative = (with_mesh(item, models) for item in scene.objects)
    return dataclasses.replace(scene, base=base, relative=relative)


def with_mesh(item: SceneObject, models: ModelSource) -> SceneObject:
    """The object with its surface, when its cloud is its model's."""
    model = models.find(item.object_id) if item.source == CloudSource.MODEL else None
    return item if model is None else dataclasses.replace(item, mesh=model.mesh)
