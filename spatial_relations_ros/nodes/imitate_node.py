"""imitate_node: a demonstrated relation in, target poses out."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError
from typing import Any

from rclpy.action import ActionServer, CancelResponse, GoalResponse
from spatial_relations_msgs.action import ImitateRelation
from spatial_relations_msgs.srv import Imitate

from spatial_relations_ros.core import ImitationError, Scene
from spatial_relations_ros.evaluation.recorded_steps import StepRecorder, shown_as_it_ran
from spatial_relations_ros.imitation import (
    ImitationOptions,
    ImitationProgress,
    ImitationResult,
    imitate,
)
from spatial_relations_ros.nodes.answer_publisher import AnswerPublisher
from spatial_relations_ros.nodes.imitate_parameters import (
    IMITATE_PARAMETERS,
    default_options,
)
from spatial_relations_ros.nodes.model_host import ModelHost
from spatial_relations_ros.nodes.node_recording import NodeRecording
from spatial_relations_ros.nodes.robot_parameters import Robot
from spatial_relations_ros.nodes.scene_client import SceneClient
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
from spatial_relations_ros.visualization.recorded_imitation import record_imitation

FEEDBACK_PERIOD_SEC = 0.05
POLL_SEC = 0.05


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
        self.serve(Imitate, 'imitate', self._on_request)
        self._action_server = ActionServer(
            self,
            ImitateRelation,
            'imitate_relation',
            execute_callback=self._on_goal,
            goal_callback=lambda _: GoalResponse.ACCEPT,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            callback_group=self.requests_group,
            goal_service_qos_profile=qos.REQUESTS,
            result_service_qos_profile=qos.REQUESTS,
            cancel_service_qos_profile=qos.REQUESTS,
        )
        self.diagnostics.expect('imitate_relation')
        self.diagnostics.add_state('model', self._host.state)
        self._host.load_early()
        self._standalone = Standalone(self, self._host, scenes)

    def close(self) -> None:
        """Ends the worker and what runs on it, and the perception of this process."""
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
        reference, seen = self._requests.resolve(request, with_others=self._robot.avoids_others)
        test = seen.scene
        defaults = default_options(self.parameters, seen.table_height)
        options = self._robot.options(options_from_request(request, test, defaults), seen)
        job = _Job(
            self._host, self._recording, reference, test, options, is_cancelled, on_progress
        )
        result = job.run()
        self._publisher.publish(result, reference, test)
        self.get_logger().info(
            f'{"/".join(reference.object_ids)} -> {"/".join(test.object_ids)}: '
            f'{result.message} ({result.duration_sec:.1f} s)'
        )
        return result, test


class _Job:
    """One imitation on the worker's thread."""

    def __init__(
        self,
        host: ModelHost,
        recording: NodeRecording,
        reference: Scene,
        test: Scene,
        options: ImitationOptions,
        is_cancelled: Callable[[], bool],
        on_progress: Callable[[ImitationProgress, Scene], None],
    ) -> None:
        self._host, self._recording = host, recording
        self._reference, self._test = reference, test
        self._steps = StepRecorder()
        self._options, self._is_cancelled, self._on_progress = options, is_cancelled, on_progress

    def run(self) -> ImitationResult:
        """Waits for the worker; a request that is cancelled in the queue never starts.

        Raises:
            ImitationError: when it was cancelled before it started.
        """
        future = self._host.worker.submit(self._work)
        while not future.done():
            if self._is_cancelled() and future.cancel():
                break
            try:
                return future.result(timeout=POLL_SEC)
            except TimeoutError:
                continue
        try:
            return future.result()
        except CancelledError:
            raise ImitationError('cancelled before it started') from None

    def _work(self) -> ImitationResult:
        metric = self._host.metric()
        result = imitate(
            metric,
            self._reference,
            self._test,
            self._options,
            on_progress=self._keep_going,
        )
        if self._recording.is_on:
            shown = shown_as_it_ran(
                self._reference, self._test, result, self._steps, self._options.table_height
            )
            self._recording.record(
                self._test.stamp_ns,
                lambda to: record_imitation(to, shown, projections=metric.projections),
            )
        return result

    def _keep_going(self, progress: ImitationProgress) -> bool:
        if self._recording.is_on:
            self._steps.record(progress)
        self._on_progress(progress, self._test)
        return not (self._is_cancelled() or self._host.worker.is_closing)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the node until it is asked to stop; returns the exit code."""
    return run_node(ImitateNode, arguments)


if __name__ == '__main__':
    sys.exit(main())
