"""What the three nodes have in common: parameters, diagnostics and guarded callbacks."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.qos import QoSProfile

from spatial_relations_ros.core import SpatialRelationsError
from spatial_relations_ros.ros.diagnostics import Diagnostics
from spatial_relations_ros.ros.parameters import Parameters, ParameterSpec


class RelationsNode(Node):
    """A node whose callbacks never end it.

    A message that cannot be used is counted, logged now and then, and reported on /diagnostics; a
    request that cannot be served is answered with ``success=false`` and the reason.

    Requests may wait for the worker thread or for another node: run the node in an executor of
    several threads (``run_nodes``). They wait instead of being coroutines because the executor of
    rclpy 7 polls a pending coroutine without a pause, which takes a whole core from the inference
    that it waits for.
    """

    def __init__(self, name: str, specs: Sequence[ParameterSpec], **node_arguments: Any) -> None:
        """Declares the parameters.

        Raises:
            ConfigError: when a parameter override cannot be used.
        """
        super().__init__(name, **node_arguments)
        self.parameters = Parameters(self, specs)
        self.diagnostics = Diagnostics(self)
        # Requests may overlap: each waits on its own thread.
        self.requests_group = ReentrantCallbackGroup()

    def close(self) -> None:
        """Stops what the node runs beside its callbacks; called before it is destroyed."""

    def subscribe(
        self,
        message_type: Any,
        topic: str,
        callback: Callable[[Any], None],
        qos: QoSProfile,
        *,
        is_listed: bool = True,
    ) -> None:
        """Subscribes with a guarded callback, one at a time and apart from other topics."""
        if is_listed:
            self.diagnostics.expect(topic)
        self.create_subscription(
            message_type,
            topic,
            self._guarded(topic, callback),
            qos,
            callback_group=MutuallyExclusiveCallbackGroup(),
        )

    def serve(self, service_type: Any, name: str, callback: Callable[[Any, Any], Any]) -> None:
        """Offers a service whose callback fills the response; errors become its message."""
        self.create_service(
            service_type,
            name,
            self._guarded_service(name, callback),
            callback_group=self.requests_group,
        )

    def report_bad(self, topic: str, error: Exception) -> str:
        """Counts and logs an error of a message or a request; returns it in words."""
        is_expected = isinstance(error, SpatialRelationsError)
        reason = str(error) if is_expected else f'{type(error).__name__}: {error}'
        if self.diagnostics.count_bad(topic, reason):
            details = '' if is_expected else f'\n{traceback.format_exc()}'
            self.get_logger().warning(f'{topic}: {reason}{details}')
        return reason

    def _guarded(self, topic: str, callback: Callable[[Any], None]) -> Callable[[Any], None]:
        def run(message: Any) -> None:
            self.diagnostics.count(topic)
            try:
                callback(message)
            except Exception as error:  # any other way the message would end the node
                self.report_bad(topic, error)

        return run

    def _guarded_service(
        self, name: str, callback: Callable[[Any, Any], Any]
    ) -> Callable[[Any, Any], Any]:
        def run(request: Any, response: Any) -> Any:
            self.diagnostics.count(name)
            try:
                callback(request, response)
            except Exception as error:  # the client gets the reason, the node lives
                fresh = type(response)()
                fresh.success, fresh.message = False, self.report_bad(name, error)
                return fresh
            return response

        return run
