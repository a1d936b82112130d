"""What a client sees of three nodes while the recorded bag is played, and what it asks them."""

from __future__ import annotations

from collections import Counter
from typing import Any

from geometry_msgs.msg import PoseArray, PoseStamped
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from ros_graph import Graph
from sensor_msgs.msg import PointCloud2
from spatial_relations_msgs.msg import Imitation, MovePlan
from spatial_relations_msgs.msg import Scene as SceneMsg
from spatial_relations_msgs.srv import GetScene, Imitate
from visualization_msgs.msg import MarkerArray

from spatial_relations_ros.nodes.demo_plan import DemoPlan
from spatial_relations_ros.ros.qos import ANSWERS, SCENES, latest_cloud


class DemoSession:
    """The graph after the bag has been played once."""

    def __init__(self, graph: Graph, plan: DemoPlan) -> None:
        self.graph, self.plan = graph, plan
        self.scenes: Counter[tuple[str, str]] = Counter()
        self.markers: list[MarkerArray] = []
        self.targets: list[PoseArray] = []
        self.single_targets: list[PoseStamped] = []
        self.grippers: list[PoseStamped] = []
        self.imitations: list[Imitation] = []
        self.plans: list[MovePlan] = []
        self.is_playing = True
        self.last_cloud: PointCloud2 | None = None
        test_id = plan.imitations[0].test_ids[1]
        graph.subscribe(SceneMsg, '/perception_node/scenes', self._on_scene, SCENES)
        graph.subscribe(MarkerArray, '/perception_node/markers', self.markers.append, SCENES)
        graph.subscribe(PoseArray, '/target_poses', self.targets.append, ANSWERS)
        graph.subscribe(
            PoseStamped, f'/target_pose/{test_id}', self.single_targets.append, ANSWERS
        )
        graph.subscribe(PoseStamped, f'/gripper_target/{test_id}', self.grippers.append, ANSWERS)
        graph.subscribe(Imitation, '/imitate_node/imitation', self.imitations.append, ANSWERS)
        graph.subscribe(MovePlan, '/imitate_node/moves', self.plans.append, ANSWERS)
        qos = latest_cloud(is_reliable=True)
        graph.subscribe(PointCloud2, plan.points_topic, self._on_cloud, qos)
        self.cloud_publisher = graph.node.create_publisher(PointCloud2, plan.points_topic, qos)

    def _on_scene(self, message: SceneMsg) -> None:
        self.scenes[message.base.object_id, message.relative.object_id] += 1

    def _on_cloud(self, message: PointCloud2) -> None:
        if self.is_playing:
            self.last_cloud = message

    @property
    def reference_ids(self) -> list[str]:
        return list(self.plan.imitations[0].reference_ids)

    @property
    def test_ids(self) -> list[str]:
        return list(self.plan.imitations[0].test_ids)

    def call(self, kind: Any, service: str, /, **fields: Any) -> Any:
        return self.graph.call(kind, service, **fields)

    def imitate(self, **fields: Any) -> Any:
        asked = {'reference_ids': self.reference_ids, 'test_ids': self.test_ids, **fields}
        return self.call(Imitate, '/imitate', **asked)

    def set_parameter(self, node: str, name: str, value: float) -> None:
        kind = ParameterType.PARAMETER_INTEGER if isinstance(value, int) else None
        setting = (
            ParameterValue(type=kind, integer_value=value)
            if kind
            else ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value)
        )
        response = self.call(
            SetParameters,
            f'/{node}/set_parameters',
            parameters=[Parameter(name=name, value=setting)],
        )
        assert response.results[0].successful, response.results[0].reason

    def show_again(self) -> None:
        """Publishes the bag's last cloud until the latest scene is its scene again."""
        assert self.last_cloud is not None
        stamp = self.last_cloud.header.stamp

        def is_seen() -> bool:
            self.cloud_publisher.publish(self.last_cloud)
            found = self.call(
                GetScene, '/perception_node/get_scene', object_ids=self.reference_ids
            )
            return bool(found.success and found.scene.header.stamp == stamp)

        self.graph.wait(is_seen, "the scene of the bag's last cloud")
