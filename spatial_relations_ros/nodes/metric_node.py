"""metric_node: embeddings, distances and the memory of relations."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from spatial_relations_msgs.srv import (
    Distance,
    Embed,
    Forget,
    ListRelations,
    Nearest,
    Recall,
    Remember,
)

from spatial_relations_ros.core import InvalidSceneError, Scene
from spatial_relations_ros.learning import RelationMetric
from spatial_relations_ros.memory import default_memory_path
from spatial_relations_ros.nodes.memory_host import MemoryHost
from spatial_relations_ros.nodes.model_host import MODEL_PARAMETERS, ModelHost
from spatial_relations_ros.nodes.scene_client import SCENE_PARAMETERS, SceneClient
from spatial_relations_ros.ros.conversions import scene_to_msg
from spatial_relations_ros.ros.parameters import ParameterSpec
from spatial_relations_ros.ros.relations_node import RelationsNode
from spatial_relations_ros.ros.running import run_node

METRIC_PARAMETERS = (
    *MODEL_PARAMETERS,
    *SCENE_PARAMETERS,
    ParameterSpec(
        'memory_path',
        '',
        'File of remembered relations; empty: below $XDG_DATA_HOME or ~/.local/share.',
        is_fixed=True,
    ),
)


class MetricNode(RelationsNode):
    """Embeds and compares scenes, remembers relations.

    Args:
        host: the metric and its thread, when several nodes of a process share them; None makes
            an own one.
        node_arguments: of rclpy's Node.
    """

    def __init__(self, host: ModelHost | None = None, **node_arguments: Any) -> None:
        super().__init__('metric_node', METRIC_PARAMETERS, **node_arguments)
        self._host = host or ModelHost.of_parameters(self.parameters)
        self._scenes = SceneClient(self)
        path = self.parameters.text('memory_path')
        self._relations = MemoryHost(
            Path(path).expanduser() if path else default_memory_path(),
            lambda message: self.get_logger().warning(message),
        )
        self.serve(Embed, '~/embed', self._embed)
        self.serve(Distance, '~/distance', self._distance)
        self.serve(Nearest, '~/nearest', self._nearest)
        self.serve(Remember, '~/remember', self._remember)
        self.serve(Recall, '~/recall', self._recall, may_wait=False)
        self.serve(Forget, '~/forget', self._forget, may_wait=False)
        self.serve(ListRelations, '~/list', self._list, may_wait=False)
        self.diagnostics.add_state('model', self._host.state)
        if host is None:
            self._host.load_early()

    def reset(self) -> str:
        """Reads weights and memory anew at the next use; what is remembered stays."""
        self._host.forget()
        self._relations.forget()
        return 'weights in memory, the open file of relations, counters'

    def close(self) -> None:
        """Ends the worker."""
        super().close()
        self._host.worker.close()

    def destroy_node(self) -> None:
        """Closes the memory, after what uses the metric."""
        self._host.worker.join()
        self._relations.forget()
        super().destroy_node()

    def _embed(self, request: Embed.Request, response: Embed.Response) -> None:
        scene = self._scenes.given_or_seen(request.scene, request.object_ids, what='scene').scene

        def job() -> tuple[list[float], str, float]:
            metric = self._host.metric()
            embedding = metric.embed_scenes([scene])[0]
            return embedding.tolist(), metric.model_hash, float(metric.novelty(embedding))

        response.embedding, response.model_hash, response.novelty = self._host.worker.run(job)
        response.is_novel = response.novelty > 1.0
        response.success = True

    def _distance(self, request: Distance.Request, response: Distance.Response) -> None:
        reference = self._reference_scene(request)
        test = self._scenes.given_or_seen(request.test_scene, request.test_ids, what='test').scene
        compared = self._host.worker.run(lambda: self._host.metric().compare(reference, test))
        response.distance = compared.distance
        response.same_relation_probability = compared.same_relation_probability
        response.reference_novelty, response.test_novelty = compared.novelty
        response.reference_is_novel, response.test_is_novel = compared.is_novel
        response.success = True

    def _reference_scene(self, request: Distance.Request) -> Scene:
        if not request.reference_name:
            return self._scenes.given_or_seen(
                request.reference_scene, request.reference_ids, what='reference'
            ).scene
        if request.reference_ids or request.reference_scene:
            raise InvalidSceneError('reference: give a name, object ids or a scene, only one')
        with self._relations.memory() as memory:
            return memory.get(request.reference_name)

    def _nearest(self, request: Nearest.Request, response: Nearest.Response) -> None:
        scene = self._scenes.given_or_seen(request.scene, request.object_ids, what='scene').scene
        metric, embedding = self._embedded(scene)

        def embed_anew(scenes: Sequence[Scene]) -> NDArray[np.float32]:
            # All that other weights embedded may take minutes: a job for each batch, so that
            # others have their turn and the node can end; what is done then is kept.
            return self._host.worker.run(lambda: metric.embed_scenes(scenes), goes_on=True)

        with self._relations.memory() as memory:
            neighbours = memory.nearest(
                embedding, int(request.k) or 1, metric.model_hash, embed=embed_anew
            )
        response.names = [neighbour.name for neighbour in neighbours]
        response.distances = [float(neighbour.distance) for neighbour in neighbours]
        response.success = bool(neighbours)
        if not neighbours:
            response.message = 'no relation is remembered'

    def _remember(self, request: Remember.Request, response: Remember.Response) -> None:
        scene = self._scenes.given_or_seen(request.scene, request.object_ids, what='scene').scene
        metric, embedding = self._embedded(scene)
        # Here and not on the metric's thread: another process may keep the file locked.
        with self._relations.memory() as memory:
            memory.remember(
                request.name, scene, embedding, metric.model_hash, replace=bool(request.replace)
            )
        response.success = True
        response.message = f'{scene.relative.object_id} to {scene.base.object_id}'

    def _embedded(self, scene: Scene) -> tuple[RelationMetric, NDArray[np.float32]]:
        """The metric, and a scene's embedding by it."""

        def job() -> tuple[RelationMetric, NDArray[np.float32]]:
            metric = self._host.metric()
            return metric, metric.embed_scenes([scene])[0]

        return self._host.worker.run(job)

    def _recall(self, request: Recall.Request, response: Recall.Response) -> None:
        with self._relations.memory() as memory:
            scene = memory.get(request.name)
        response.scene = scene_to_msg(scene)
        response.success = True

    def _forget(self, request: Forget.Request, response: Forget.Response) -> None:
        with self._relations.memory() as memory:
            memory.forget(request.name)
        response.success = True

    def _list(self, _: ListRelations.Request, response: ListRelations.Response) -> None:
        with self._relations.memory() as memory:
            relations = memory.list()
        response.names = [relation.name for relation in relations]
        response.base_ids = [relation.base_id for relation in relations]
        response.relative_ids = [relation.relative_id for relation in relations]
        response.success = True


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the node until it is asked to stop; returns the exit code."""
    return run_node(MetricNode, arguments)


if __name__ == '__main__':
    sys.exit(main())
