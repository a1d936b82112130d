"""Asks the perception node for scenes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from spatial_relations_msgs.msg import Scene as SceneMsg
from spatial_relations_msgs.srv import GetScene

from spatial_relations_ros.core import InvalidSceneError, Scene, SceneObject, UnknownObjectError
from spatial_relations_ros.perception.point_cloud2 import read_xyz
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.conversions import (
    one_scene,
    scene_from_msg,
    scene_object_from_msg,
)
from spatial_relations_ros.ros.parameters import ParameterSpec
from spatial_relations_ros.ros.relations_node import RelationsNode
from spatial_relations_ros.ros.waiting import SHUTTING_DOWN, NoAnswerError, wait_for, wait_until

SCENE_PARAMETERS = (
    ParameterSpec(
        'perception',
        'perception_node',
        'Name of the perception node; relative to the namespace.',
        is_fixed=True,
    ),
    ParameterSpec(
        'world_frame',
        'world',
        'Frame in which scenes of requests must be, z up against gravity; as perception has it.',
        is_fixed=True,
    ),
    ParameterSpec(
        'service_timeout',
        5.0,
        'Longest wait for an answer of another node, seconds.',
        minimum=0.1,
        maximum=600.0,
    ),
)


@dataclass(frozen=True)
class SeenScene:
    """A scene with what else was seen.

    Attributes:
        scene: of the two objects.
        table_height: world z of the table, metres; None when it is not known.
        others: the other objects, when asked for.
        clutter: (N, 3) world points that belong to no object; None when nobody looked.
    """

    scene: Scene
    table_height: float | None = None
    others: tuple[SceneObject, ...] = ()
    clutter: NDArray[np.float32] | None = None


class SceneClient:
    """Scenes by object ids, from the perception node; errors are as clear as that node's."""

    def __init__(self, node: RelationsNode) -> None:
        self._node = node
        self.service_name = f'{node.parameters.text("perception")}/get_scene'
        self._client = node.create_client(
            GetScene,
            self.service_name,
            qos_profile=qos.REQUESTS,
            callback_group=node.requests_group,
        )

    @property
    def is_ready(self) -> bool:
        """Whether a perception node is there now."""
        return bool(self._client.service_is_ready())

    def seen(self, object_ids: Sequence[str], *, with_others: bool = False) -> SeenScene:
        """The scene of two objects as they are seen now.

        Args:
            object_ids: base and relative.
            with_others: whether to ask for what else is seen at the same time.

        Raises:
            UnknownObjectError: when an object is not seen; names those that are.
            NoAnswerError: when no perception node answers.
        """
        request = GetScene.Request(object_ids=list(object_ids), with_others=with_others)
        response = call(self._node, self._client, request)
        if not response.success:
            raise UnknownObjectError(response.message)
        table_height = float(response.table_height)
        clutter = response.clutter
        return SeenScene(
            scene_from_msg(response.scene),
            None if math.isnan(table_height) else table_height,
            tuple(scene_object_from_msg(item) for item in response.others),
            read_xyz(clutter).points if clutter.width and clutter.fields else None,
        )

    def given_or_seen(
        self,
        scenes: Sequence[SceneMsg],
        object_ids: Sequence[str],
        *,
        what: str,
        with_others: bool = False,
    ) -> SeenScene:
        """The scene of a request that holds either a scene or two object ids.

        Args:
            scenes: at most one.
            object_ids: base and relative, or empty.
            what: names the part of the request in errors.
            with_others: whether to ask for what else is seen; a scene that is given has nothing
                else.

        Raises:
            InvalidSceneError: when both or none are given, or the scene is in another frame than
                the parameter ``world_frame`` says.
        """
        if scenes and object_ids:
            raise InvalidSceneError(f'{what}: give object ids or a scene, not both')
        world_frame = self._node.parameters.text('world_frame')
        given = one_scene(scenes, what, world_frame=world_frame)
        if given is not None:
            return SeenScene(given)
        if not object_ids:
            raise InvalidSceneError(
                f'{what}: nothing is given; name two objects as [base, relative] or give a scene'
            )
        return self.seen(object_ids, with_others=with_others)


def call(node: RelationsNode, client: Any, request: Any) -> Any:
    """Calls another node's service and waits for its answer.

    Raises:
        NoAnswerError: when the service is not there or does not answer in time, or the node is
            shutting down.
    """
    timeout_sec = node.parameters.number('service_timeout')
    wait_until(lambda: node.is_closing or client.service_is_ready(), timeout_sec)
    if node.is_closing:
        raise NoAnswerError(SHUTTING_DOWN)
    if not client.service_is_ready():
        raise NoAnswerError(
            f'no service {client.srv_name}: is its node running, and in the same namespace?'
        )
    future = client.call_async(request)
    try:
        return wait_for(future, timeout_sec, lambda: node.is_closing)
    except NoAnswerError as error:
        client.remove_pending_request(future)
        raise NoAnswerError(f'{client.srv_name}: {error}') from error
