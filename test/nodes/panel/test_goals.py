"""Goals whose server ends while it works."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import Future as JobFuture
from pathlib import Path

import pytest
import rclpy
from rclpy.context import Context
from rclpy.parameter import Parameter
from spatial_relations_msgs.action import ImitateRelation

from spatial_relations_ros.nodes.panel.goals import Goals
from spatial_relations_ros.nodes.panel_parameters import PANEL_PARAMETERS
from spatial_relations_ros.ros.domains import free_domain_id
from spatial_relations_ros.ros.relations_node import RelationsNode
from spatial_relations_ros.ros.running import SpinThread, WaitingExecutor
from spatial_relations_ros.ros.waiting import NoAnswerError, Worker

pytestmark = pytest.mark.ros

LIMIT_SEC = 60.0
# A killed participant counts as being there for so long; 20 s unless a profile says otherwise.
LEASE = """<?xml version="1.0" encoding="UTF-8"?>
<profiles xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles">
  <participant profile_name="short" is_default_profile="true"><rtps><builtin><discovery_config>
    <leaseDuration><sec>2</sec></leaseDuration>
    <leaseAnnouncement><sec>0</sec><nanosec>500000000</nanosec></leaseAnnouncement>
  </discovery_config></builtin></rtps></participant>
</profiles>
"""
SERVER = """
import time
import rclpy
from rclpy.action import ActionServer, CancelResponse
from rclpy.executors import MultiThreadedExecutor
from spatial_relations_msgs.action import ImitateRelation

def execute(goal):
    while not goal.is_cancel_requested:
        goal.publish_feedback(ImitateRelation.Feedback(step=1))
        time.sleep(0.05)
    goal.canceled()
    return ImitateRelation.Result(message='the best so far')

rclpy.init()
node = rclpy.create_node('server')
server = ActionServer(
    node, ImitateRelation, 'imitate_relation', execute,
    cancel_callback=lambda _: CancelResponse.ACCEPT,
)
executor = MultiThreadedExecutor(4)
executor.add_node(node)
executor.spin()
"""


class Servers:
    """Action servers as processes of their own, which work until they are cancelled or killed."""

    def __init__(self, folder: Path) -> None:
        profile = folder / 'lease.xml'
        profile.write_text(LEASE)
        self._environment = {**os.environ, 'FASTRTPS_DEFAULT_PROFILES_FILE': str(profile)}
        self._processes: list[subprocess.Popen[bytes]] = []

    def start(self) -> None:
        command = [sys.executable, '-c', SERVER]
        self._processes.append(subprocess.Popen(command, env=self._environment))

    def kill(self) -> None:
        for process in self._processes:
            process.send_signal(signal.SIGKILL)
            process.wait()
        self._processes.clear()


class Client(RelationsNode):
    """Has goals, and feedback that it waits for."""

    def __init__(self, context: Context) -> None:
        super().__init__('client', PANEL_PARAMETERS, context=context)
        self.goals = Goals(self)
        self.worker = Worker()
        self.has_feedback = threading.Event()

    def send(self) -> JobFuture[ImitateRelation.Result]:
        self.has_feedback.clear()
        self.goals.begin()
        goal = ImitateRelation.Goal()
        return self.worker.submit(
            lambda: self.goals.result(goal, lambda _: self.has_feedback.set())
        )

    def close(self) -> None:
        super().close()
        self.worker.close()

    def destroy_node(self) -> None:
        self.worker.join()
        self.goals.destroy()
        super().destroy_node()


@pytest.fixture
def servers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Servers]:
    monkeypatch.setenv('ROS_DOMAIN_ID', str(free_domain_id()))
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    servers = Servers(tmp_path)
    yield servers
    servers.kill()


@pytest.fixture
def client(servers: Servers) -> Iterator[Client]:
    context = Context()
    rclpy.init(context=context)
    client = Client(context)
    client.set_parameters([Parameter('service_timeout', value=LIMIT_SEC)])
    spinning = SpinThread(WaitingExecutor(8, context=context), client)
    yield client
    spinning.close()
    rclpy.shutdown(context=context)


def test_a_server_that_is_killed_and_started_anew_is_not_waited_for(
    client: Client, servers: Servers
) -> None:
    """The new one knows nothing of the goal, however long it is there."""
    servers.start()
    lost = client.send()
    assert client.has_feedback.wait(LIMIT_SEC)
    servers.kill()
    servers.start()
    with pytest.raises(NoAnswerError, match='went away while it worked'):
        lost.result(LIMIT_SEC)
    found = client.send()
    client.goals.cancel()
    assert found.result(LIMIT_SEC).message == 'the best so far'


def test_a_client_that_shuts_down_waits_for_nothing(client: Client, servers: Servers) -> None:
    servers.start()
    waiting = client.send()
    assert client.has_feedback.wait(LIMIT_SEC)
    client.close()
    with pytest.raises(NoAnswerError, match='shutting down'):
        waiting.result(LIMIT_SEC)
