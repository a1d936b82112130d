"""imitate_node: a demonstrated relation in, target poses out."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.action import ActionServer, CancelResponse, GoalResponse
from spatial_relations_msgs.action import ImitateRelation
from spatial_relations_msgs.srv import Imitate

from spatial_relations_ros.core import Scene
from spatial_relations_ros.imitation import (
    ImitationOptions,
    ImitationProgress,
    ImitationResult,
)
from spatial_relations_ros.nodes.answer_publisher import AnswerPublisher
from spatial_relations_ros.nodes.follower import Follower
from spatial_relations_ros.nodes.imitate_parameters import (
    IMITATE_PARAMETERS,
    default_options,
)
from spatial_relations_ros.nodes.imitation_job import ImitationJob
from spatial_relations_ros.nodes.model_host import ModelHost
from spatial_relations_ros.nodes.node_recording import NodeRecording
from spatial_relations_ros.nodes.robot_parameters import Robot
from spatial_relations_ros.nodes.scene_client import SceneClient, SeenScene
from spatial_relations_ros.nodes.scene_requests import SceneRequests
from spatial_relations_ros.nodes.standalone import Standalone
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.imitation_messages import (
    fill_result,
    options_from_request,
    progress_to_feedback,
)
from spatial_relations_ros.ros.relations_node import RelationsNode
from spatial_relations_ros.ros.running import run_node

FEEDBACK_PERIOD_SEC = 0.05
RESULT_TIMEOUT_SEC = 10


class ImitateNode(RelationsNode):
    """Answers imitation requests, as a service and as an action."""

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__('imitate_node', IMITATE_PARAMETERS, **node_arguments)
        try:
            self._recording = NodeRecording(self)
        except Exception:  # half a node must not stay in the graph
            super().destroy_node()
            raise
        self._host = ModelHost.of_parameters(self.parameters)
        scenes = SceneClient(self)
        self._requests = SceneRequests(self, scenes)
        self._publisher = AnswerPublisher(self)
        self._robot = Robot(self)
        # A reset cancels what runs: jobs of an older count.
        self._num_resets = 0
        self.serve(Imitate, 'imitate', self._on_request)
        self._action_server = ActionServer(
            self,
            ImitateRelation,
            'imitate_relation',
            execute_callback=self._on_goal,
            goal_callback=lambda _: GoalResponse.ACCEPT,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            callback_group=self.requests_group,
            # Goals that have ended are kept with their scenes until then.
            result_timeout=RESULT_TIMEOUT_SEC,
            goal_service_qos_profile=qos.REQUESTS,
            result_service_qos_profile=qos.REQUESTS,
            cancel_service_qos_profile=qos.REQUESTS,
        )
        self.diagnostics.expect('imitate_relation')
        self.diagnostics.add_state('model', self._host.state)
        self._host.load_early()
        self._standalone = Standalone(self, self._host, scenes)
        self._follower = Follower(self, self._resolve, self._options, self._run)

    def reset(self) -> str:
        """Cancels what runs; weights are read again, and following begins anew."""
        self._num_resets += 1
        self._host.forget()
        self._follower.forget()
        return 'running requests, weights in memory, what was followed, counters'

    def close(self) -> None:
        """Ends the worker and what runs on it, and the perception of this process."""
        super().close()
        self._follower.close()
        self._host.worker.close()
        self._standalone.close()
        self._recording.close()

    def destroy_node(self) -> None:
        """Destroys the action server first."""
        self._action_server.destroy()
        super().destroy_node()

    def _on_request(self, request: Imitate.Request, response: Imitate.Response) -> None:
        result, test = self._imitate(request, lambda: False, lambda *_: None)
        fill_result(response, result, test)

    def _on_goal(self, goal: Any) -> ImitateRelation.Result:
        """Carries out one goal; the action server calls it on a thread of the executor."""
        self.diagnostics.count('imitate_relation')
        message = ImitateRelation.Result()
        last_feedback_sec = 0.0

        def send_feedback(progress: ImitationProgress, test: Scene) -> None:
            nonlocal last_feedback_sec
            if time.monotonic() - last_feedback_sec >= FEEDBACK_PERIOD_SEC:
                last_feedback_sec = time.monotonic()
                goal.publish_feedback(progress_to_feedback(progress, test))

        try:
            with self.place_for_request():
                result, test = self._imitate(
                    goal.request, lambda: goal.is_cancel_requested, send_feedback
                )
            fill_result(message, result, test)
        except Exception as error:  # the client gets the reason, the node lives
            message.message = self.report_bad('imitate_relation', error)
        if goal.is_cancel_requested:
            goal.canceled()
        elif message.success:
            goal.succeed()
        else:
            goal.abort()
        return message

    def _imitate(
        self,
        request: Any,
        is_cancelled: Callable[[], bool],
        on_progress: Callable[[ImitationProgress, Scene], None],
    ) -> tuple[ImitationResult, Scene]:
        """Resolves the scenes, runs the imitation on the worker and publishes its answer."""
        reference, seen = self._resolve(request)
        options = self._options(request, seen)
        result = self._run(reference, seen, options, is_cancelled, on_progress)
        self.get_logger().info(
            f'{"/".join(reference.object_ids)} -> {"/".join(seen.scene.object_ids)}: '
            f'{result.message} ({result.duration_sec:.1f} s)'
        )
        return result, seen.scene

    def _resolve(self, request: Any) -> tuple[Scene, SeenScene]:
        return self._requests.resolve(request, with_others=self._robot.avoids_others)

    def _options(self, request: Any, seen: SeenScene) -> ImitationOptions:
        defaults = default_options(self.parameters, seen.table_height)
        return self._robot.options(options_from_request(request, seen.scene, defaults), seen)

    def _run(
        self,
        reference: Scene,
        seen: SeenScene,
        options: ImitationOptions,
        is_cancelled: Callable[[], bool],
        on_progress: Callable[[ImitationProgress, Scene], None],
    ) -> ImitationResult:
        """Runs one imitation on the worker and publishes its answer."""
        num_resets = self._num_resets
        job = ImitationJob(
            self._host,
            self._recording,
            reference,
            seen.scene,
            options,
            lambda: is_cancelled() or self._num_resets != num_resets,
            on_progress,
        )
        result = job.run()
        self._publisher.publish(result, reference, seen.scene)
        return result


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the node until it is asked to stop; returns the exit code."""
    return run_node(ImitateNode, arguments)


if __name__ == '__main__':
    sys.exit(main())
