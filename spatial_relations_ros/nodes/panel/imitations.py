"""Runs the imitations that a page asks for, one at a time, on the imitate node."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from spatial_relations_msgs.action import ImitateRelation
from spatial_relations_msgs.srv import Recall

from spatial_relations_ros.core import Scene, SpatialRelationsError, UnknownRelationError
from spatial_relations_ros.nodes.panel.answers import progress_content, result_content
from spatial_relations_ros.nodes.panel.commands import ImitateCommand
from spatial_relations_ros.nodes.panel.goals import Goals
from spatial_relations_ros.nodes.panel.seen_objects import Shapes
from spatial_relations_ros.nodes.scene_client import SceneClient, call
from spatial_relations_ros.nodes.scene_requests import with_meshes
from spatial_relations_ros.perception.object_models import ModelSource
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.conversions import scene_from_msg
from spatial_relations_ros.ros.relations_node import RelationsNode
from spatial_relations_ros.ros.waiting import BusyError, Worker
from spatial_relations_ros.visualization.report import scene_content
from spatial_relations_ros.visualization.shown_imitation import lowest_point

Publish = Callable[[str, dict[str, Any]], None]


class Imitations:
    """A client of the action ``imitate_relation``.

    Args:
        node: with the parameters ``imitate_relation``, ``answer_timeout`` and ``metric``.
        scenes: of the perception node.
        models: give objects their surfaces.
        shapes: get what is to be drawn.
        publish: gets ``job``, ``progress`` and ``result``.
    """

    def __init__(
        self, node: RelationsNode, scenes: SceneClient, models: ModelSource, shapes: Shapes,
        publish: Publish,
    ) -> None:  # fmt: skip
        self._node, self._scenes, self._models = node, scenes, models
        self._shapes, self._publish = shapes, publish
        self._goals = Goals(node)
        self._recall = node.create_client(
            Recall,
            f'{node.parameters.text("metric")}/recall',
            qos_profile=qos.REQUESTS,
            callback_group=node.requests_group,
        )
        self._worker = Worker(max_pending=1)
        self._lock = threading.Lock()

    def close(self) -> None:
        """Gives up what runs."""
        self._worker.close()

    def destroy(self) -> None:
        """Destroys the client of the action, after the job that uses it and before its node."""
        self._worker.join()
        self._goals.destroy()

    def start(self, command: ImitateCommand) -> None:
        """Asks for an imitation and returns; what comes of it is published.

        Raises:
            BusyError: while another one runs.
            NoAnswerError: when a node does not answer.
            UnknownObjectError, UnknownRelationError: when a scene is not known.
        """
        try:
            with self._lock:
                self._worker.submit(lambda: self._run(command))
                self._goals.begin()
        except BusyError:
            raise BusyError('an imitation runs already; cancel it or wait for it') from None

    def cancel(self) -> bool:
        """Ends the running one with its best answer so far; False when none runs."""
        with self._lock:
            if not self._worker.num_pending:
                return False
            self._goals.cancel()
        return True

    def _run(self, command: ImitateCommand) -> None:
        base, relative = command.test_ids
        self._publish('job', {'running': True, 'message': f'{relative} to {base}'})
        problem = ''
        try:
            self._imitate(command)
        except SpatialRelationsError as error:
            problem = str(error)
        except Exception as error:  # else the page would wait for ever
            problem = self._node.report_bad('imitate_relation', error)
        self._publish('job', {'running': False, 'message': problem})

    def _imitate(self, command: ImitateCommand) -> None:
        reference = self._reference(command)
        seen = self._scenes.seen(command.test_ids)
        test = with_meshes(seen.scene, self._models)
        table = seen.table_height
        scenes = {
            'reference': scene_content(reference, lowest_point(reference), self._shapes),
            'test': scene_content(
                test, lowest_point(test) if table is None else table, self._shapes
            ),
        }
        goal = ImitateRelation.Goal(
            reference_ids=list(command.reference_ids),
            reference_name=command.reference_name,
            test_ids=list(command.test_ids),
            movable_ids=list(command.movable_ids),
            num_answers=command.num_answers,
            time_budget=command.time_budget_sec,
            keep_heading=command.keep_heading,
        )
        result = self._goals.result(goal, self._on_feedback)
        self._publish('result', result_content(result, **scenes))

    def _reference(self, command: ImitateCommand) -> Scene:
        if not command.reference_name:
            return with_meshes(self._scenes.seen(command.reference_ids).scene, self._models)
        response = call(self._node, self._recall, Recall.Request(name=command.reference_name))
        if not response.success:
            raise UnknownRelationError(response.message)
        return scene_from_msg(response.scene)

    def _on_feedback(self, message: Any) -> None:
        try:
            self._publish('progress', progress_content(message.feedback))
        except SpatialRelationsError as error:
            self._node.report_bad('imitate_relation', error)
