"""What the three nodes have in common: parameters, diagnostics and guarded callbacks."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from typing import Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_srvs.srv import Trigger

from spatial_relations_ros.core import ConfigError, SpatialRelationsError
from spatial_relations_ros.ros import qos as profiles
from spatial_relations_ros.ros.diagnostics import Diagnostics
from spatial_relations_ros.ros.parameters import Parameters, ParameterSpec
from spatial_relations_ros.ros.same_name import SameName
from spatial_relations_ros.ros.waiting import SHUTTING_DOWN, BusyError

# Of one node, at a time; requests beyond it are answered at once.
MAX_WAITING_REQUESTS = 8


class RelationsNode(Node):
    """A node whose callbacks never end it.

    A message that cannot be used is counted, logged now and then, and reported on /diagnostics; a
    request that cannot be served is answered with ``success=false`` and the reason.

    Requests may wait for the worker thread or for another node: run the node in an executor of
    several threads (``run_node``). They wait instead of being coroutines because the executor of
    rclpy 7 polls a pending coroutine without a pause, which takes a whole core from the inference
    that it waits for.
    """

    def __init__(self, name: str, specs: Sequence[ParameterSpec], **node_arguments: Any) -> None:
        """Declares the parameters.

        Raises:
            ConfigError: when a parameter override cannot be used.
        """
        super().__init__(name, **node_arguments)
        try:
            self.parameters = Parameters(self, specs)
        except ConfigError:  # half a node must not stay in the graph
            Node.destroy_node(self)
            raise
        self.diagnostics = Diagnostics(self)
        self.diagnostics.add_state('name', SameName(self).state)
        # Requests may overlap: each waits on its own thread.
        self.requests_group = ReentrantCallbackGroup()
        self._places_lock = threading.Lock()
        self._num_served = 0
        self._closing = threading.Event()
        self.serve(Trigger, '~/reset', self._on_reset, may_wait=False)

    def reset(self) -> str:
        """Brings the node's memory to the state after the start; parameters stay.

        Returns:
            What was forgotten, in words.
        """
        return 'counters'

    def _on_reset(self, _: Trigger.Request, response: Trigger.Response) -> None:
        forgotten = self.reset()
        self.diagnostics.clear()
        self.get_logger().info(f'reset on request: {forgotten}')
        response.success, response.message = True, f'forgotten: {forgotten}'

    @property
    def is_closing(self) -> bool:
        """Whether callbacks should come to an end."""
        return self._closing.is_set()

    def close(self) -> None:
        """Stops what the node runs beside its callbacks, and what callbacks wait for.

        Called while the node still spins, and once more before it is destroyed.
        """
        self._closing.set()

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

    def serve(
        self,
        service_type: Any,
        name: str,
        callback: Callable[[Any, Any], Any],
        *,
        may_wait: bool = True,
    ) -> None:
        """Offers a service whose callback fills the response; errors become its message.

        Args:
            service_type: of the service.
            name: of the service.
            callback: gets the request and the response.
            may_wait: whether the callback waits for the worker or another node, so that only
                ``MAX_WAITING_REQUESTS`` are served at a time.
        """
        self.create_service(
            service_type,
            name,
            self._guarded_service(name, callback, may_wait=may_wait),
            qos_profile=profiles.REQUESTS,
            callback_group=self.requests_group,
        )

    @contextmanager
    def place_for_request(self) -> Iterator[None]:
        """Holds one of the node's places for requests that wait.

        Without a limit a burst would take all threads of the executor, and none would be left
        for the answers that they wait for.

        Raises:
            BusyError: when all places are taken, or the node is shutting down.
        """
        with self._places_lock:
            if self.is_closing:
                raise BusyError(SHUTTING_DOWN)
            if self._num_served >= MAX_WAITING_REQUESTS:
                raise BusyError(
                    f'busy: {self._num_served} requests are being served already; try again later'
                )
            self._num_served += 1
        try:
            yield
        finally:
            with self._places_lock:
                self._num_served -= 1

    @property
    def is_idle(self) -> bool:
        """Whether no request holds a place."""
        return not self._num_served

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
        self, name: str, callback: Callable[[Any, Any], Any], *, may_wait: bool
    ) -> Callable[[Any, Any], Any]:
        def run(request: Any, response: Any) -> Any:
            self.diagnostics.count(name)
            try:
                with self.place_for_request() if may_wait else nullcontext():
                    callback(request, response)
            except Exception as error:  # the client gets the reason, the node lives
                fresh = type(response)()
                fresh.success, fresh.message = False, self.report_bad(name, error)
                return fresh
            return response

        return run
