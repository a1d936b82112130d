"""A graph of real node processes with a client in the test's own process."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.action import ActionClient
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile

from spatial_relations_ros.ros.domains import free_domain_id
from spatial_relations_ros.ros.processes import NodeProcesses, local_graph
from spatial_relations_ros.ros.running import SpinThread
from spatial_relations_ros.ros.waiting import NoAnswerError, sent_by, wait_for, wait_until

# Limits, not waits: a busy machine needs most of a minute to import PyTorch in three processes.
START_SEC = 150.0
ANSWER_SEC = 90.0
RETRY_SEC = 5.0


class Graph:
    """Node processes on a domain of their own, and a node that talks to them."""

    def __init__(self, folder: Path) -> None:
        domain_id = free_domain_id()
        environment = local_graph(domain_id, folder / 'log')
        os.environ.update(environment)
        self.processes = NodeProcesses(environment, folder / 'log')
        self.context = Context()
        rclpy.init(context=self.context, domain_id=domain_id)
        self.node = Node('test_client', context=self.context)
        self.diagnostics: dict[str, Any] = {}
        self.subscribe(DiagnosticArray, '/diagnostics', self._on_diagnostics, 100)
        self._spinning = SpinThread(SingleThreadedExecutor(context=self.context), self.node)
        self._clients: dict[str, Any] = {}

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self.diagnostics[status.name] = status

    def diagnostic(self, name: str) -> dict[str, str]:
        """The values last reported under a name, with its message and level."""
        status = self.diagnostics.get(name)
        if status is None:
            return {'message': '', 'level': ''}
        values = {item.key: item.value for item in status.values}
        return {**values, 'message': status.message, 'level': str(int.from_bytes(status.level))}

    def subscribe(
        self, kind: Any, topic: str, callback: Callable[[Any], None], qos: QoSProfile | int
    ) -> None:
        self.node.create_subscription(kind, topic, callback, qos)

    def _client(self, kind: Any, service: str) -> Any:
        if service not in self._clients:
            self._clients[service] = self.node.create_client(kind, service)
        return self._clients[service]

    def call(self, kind: Any, service: str, /, **fields: Any) -> Any:
        """Calls a service, waiting for it to come up."""
        client = self._client(kind, service)
        self.wait(client.service_is_ready, f'service {service}', START_SEC)
        return wait_for(client.call_async(kind.Request(**fields)), ANSWER_SEC)

    def call_until_answered(self, kind: Any, service: str, /, **fields: Any) -> Any:
        """Calls again when no answer comes: a killed node seems to be there for 20 s."""
        answers: list[Any] = []
        client = self._client(kind, service)

        def is_answered() -> bool:
            future = client.call_async(kind.Request(**fields))
            try:
                answers.append(wait_for(future, RETRY_SEC))
            except NoAnswerError:
                client.remove_pending_request(future)
            return bool(answers)

        self.wait(is_answered, f'an answer of {service}', START_SEC)
        return answers[0]

    def action(self, kind: Any, name: str) -> ActionClient:
        client = ActionClient(self.node, kind, name)
        self.wait(client.server_is_ready, f'action {name}', START_SEC)
        return client

    def sent(self, send: Callable[[], Any]) -> Any:
        """The future of what an action client sends, sent on the thread that hears answers."""
        return sent_by(self.node.executor, send, ANSWER_SEC)

    def wait(
        self, condition: Callable[[], bool], what: str, timeout_sec: float = ANSWER_SEC
    ) -> None:
        """Fails with the nodes' words when one ends, or the condition is late."""

        def holds() -> bool:
            self.processes.check()
            if self._spinning.error is not None:
                raise self._spinning.error
            return condition()

        assert wait_until(holds, timeout_sec), f'{what} did not come within {timeout_sec:g} s'

    def close(self) -> dict[str, int]:
        codes = self.processes.stop()
        self._spinning.close()
        rclpy.shutdown(context=self.context)
        return codes


def running_graph(folder: Path) -> Iterator[Graph]:
    """What the fixtures of a graph yield; at the end all nodes must have ended well."""
    graph = Graph(folder)
    yield graph
    codes = graph.close()
    assert set(codes.values()) <= {0}, f'exit codes {codes}'
