"""Remembered relations, kept by the metric node."""

from __future__ import annotations

from typing import Any

from spatial_relations_msgs.srv import Forget, ListRelations, Remember

from spatial_relations_ros.core import SpatialRelationsError
from spatial_relations_ros.nodes.panel.commands import ForgetCommand, RememberCommand
from spatial_relations_ros.nodes.scene_client import call
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.relations_node import RelationsNode


class RefusedError(SpatialRelationsError):
    """What another node refused, in its words."""


class Relations:
    """A client of the metric node's memory.

    Args:
        node: with the parameter ``metric``.
    """

    def __init__(self, node: RelationsNode) -> None:
        self._node = node
        self._remember = self._client(Remember, 'remember')
        self._forget = self._client(Forget, 'forget')
        self._list = self._client(ListRelations, 'list')

    def _client(self, kind: Any, name: str) -> Any:
        return self._node.create_client(
            kind,
            f'{self._node.parameters.text("metric")}/{name}',
            qos_profile=qos.REQUESTS,
            callback_group=self._node.requests_group,
        )

    @property
    def is_ready(self) -> bool:
        """Whether a metric node is there now."""
        return bool(self._list.service_is_ready())

    def remember(self, command: RememberCommand) -> str:
        """Remembers the relation of two objects that are seen; says which.

        Raises:
            RefusedError: when the name is taken or an object is not seen.
            NoAnswerError: when no metric node answers.
        """
        request = Remember.Request(
            name=command.name, object_ids=list(command.object_ids), replace=command.replace
        )
        return f'remembered {command.name}: {self._asked(self._remember, request).message}'

    def forget(self, command: ForgetCommand) -> str:
        """Forgets a relation; raises as ``remember`` does."""
        self._asked(self._forget, Forget.Request(name=command.name))
        return f'forgot {command.name}'

    def content(self) -> list[dict[str, str]]:
        """Name and object ids of each; raises as ``remember`` does."""
        answer = self._asked(self._list, ListRelations.Request())
        return [
            {'name': str(name), 'base': str(base), 'relative': str(relative)}
            for name, base, relative in zip(
                answer.names, answer.base_ids, answer.relative_ids, strict=True
            )
        ]

    def _asked(self, client: Any, request: Any) -> Any:
        response = call(self._node, client, request)
        if not response.success:
            raise RefusedError(response.message)
        return response
