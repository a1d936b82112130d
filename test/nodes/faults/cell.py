"""A sensor and a tracker whose messages a test sends one by one to a perception node."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ros_graph import Graph
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2
from simulated_table import SimulatedTable
from spatial_relations_msgs.msg import Scene as SceneMsg
from spatial_relations_msgs.msg import TrackedObjectArray
from spatial_relations_msgs.srv import GetScene

from spatial_relations_ros.perception.messages import stamp_ns
from spatial_relations_ros.perception.series import NS_PER_SEC
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.conversions import header_to_msg

START_NS = 1_700_000_000 * NS_PER_SEC
# A small image: perception of it takes a few milliseconds.
WIDTH = 200


class Cell:
    """Two boxes on a table, seen by a perception node of a graph.

    Args:
        graph: gets the node.
        folder: for the models of the boxes.
        name: of the node.
        parameters: of the node, besides those that this cell needs.
    """

    def __init__(
        self, graph: Graph, folder: Path, *, name: str = 'perception_node', **parameters: Any
    ) -> None:
        self.graph, self.name = graph, name
        self.models = folder
        self.table = SimulatedTable(folder, WIDTH)
        self.stamp_ns = START_NS
        self.step_ns = NS_PER_SEC // 10
        self.parameters = {
            'models_path': str(folder),
            'camera_pose': self.table.camera_pose,
            'camera_frame': 'camera',
            'publish_rate': 100.0,
            **parameters,
        }
        self.start()
        node = graph.node
        self.clouds = node.create_publisher(
            PointCloud2, f'/{name}/points', qos.latest_cloud(is_reliable=True)
        )
        self.tracks = node.create_publisher(
            TrackedObjectArray, f'/{name}/tracked_objects', qos.TRACKED_POSES
        )
        self.clock = node.create_publisher(Clock, '/clock', qos.TRACKED_POSES)
        self.last = GetScene.Response()
        # Stamps of the scenes that the node has published.
        self.published: set[int] = set()
        graph.subscribe(SceneMsg, f'/{name}/scenes', self._on_scene, qos.SCENES)

    def start(self) -> None:
        """Starts the node, the first time or after its end."""
        self.graph.processes.start(
            'perception_node',
            parameters=self.parameters,
            arguments=['-r', f'__node:={self.name}'],
            name=self.name,
        )

    def _on_scene(self, scene: SceneMsg) -> None:
        self.published.add(stamp_ns(scene.header.stamp))

    def tick(self) -> int:
        """A tenth of a second goes by for sensor, tracker and /clock."""
        self.stamp_ns += self.step_ns
        self.send_clock()
        return self.stamp_ns

    def send_clock(self) -> None:
        """Only nodes with use_sim_time listen."""
        self.clock.publish(Clock(clock=header_to_msg(self.stamp_ns, '').stamp))

    def show(self) -> None:
        """A pose of each object and a cloud, as all is well."""
        stamp_ns = self.tick()
        self.tracks.publish(self.table.tracks(stamp_ns))
        self.clouds.publish(self.table.cloud(stamp_ns))

    def ask(self) -> GetScene.Response:
        """The scene of both objects."""
        self.last = self.graph.call_until_answered(
            GetScene, f'/{self.name}/get_scene', object_ids=['box', 'post']
        )
        return self.last

    def wait_well(self, timeout_sec: float = 60.0) -> str:
        """Until objects of a cloud that is sent now are believed; gives how many it took."""
        first_ns = self.stamp_ns
        num_sent = 0

        def is_well() -> bool:
            nonlocal num_sent
            num_sent += 1
            self.show()
            answer = self.ask()
            return bool(
                answer.success
                and stamp_ns(answer.scene.header.stamp) > first_ns
                and answer.scene.relative.support > 0.6
            )

        self.graph.wait(is_well, f'a scene ({self.last.message or "no answer"})', timeout_sec)
        return f'{num_sent} cloud{"" if num_sent == 1 else "s"}'

    def wait_refused(self, words: str, send: Callable[[], None]) -> str:
        """Sends something until the scene is refused with these words; gives all of them."""

        def is_refused() -> bool:
            send()
            answer = self.ask()
            return not answer.success and words in answer.message

        self.graph.wait(is_refused, f'{words!r} (said: {self.last.message!r})', 60.0)
        return str(self.last.message)

    def diagnostic(self, part: str) -> dict[str, str]:
        return self.graph.diagnostic(f'{self.name}: {part}')
