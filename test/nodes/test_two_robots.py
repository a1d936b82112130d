"""Two robots on one domain, each with nodes in a namespace of its own; object ids are the same.

The second robot's table is half a metre higher, so that what comes from it can be told apart.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import PoseArray
from ros_graph import START_SEC, Graph
from sensor_msgs.msg import PointCloud2
from simulated_table import PLACES, SimulatedTable
from spatial_relations_msgs.msg import TrackedObjectArray
from spatial_relations_msgs.srv import GetScene, Imitate, ListRelations, Remember

from spatial_relations_ros.perception.series import NS_PER_SEC
from spatial_relations_ros.ros import qos

pytestmark = pytest.mark.ros

HEIGHTS = {'/robot1': 0.0, '/robot2': 0.5}
PAIR = ['box', 'post']
START_NS = 1_700_000_000 * NS_PER_SEC


class Robot:
    """imitate_node with perception and metric in its process, before its own sensor and tracker.

    Args:
        graph: gets the node; it is not told to be alone, and has to find that out.
        namespace: of all its names.
        folder: for models and memory.
        weights: of the metric.
    """

    def __init__(self, graph: Graph, namespace: str, folder: Path, weights: Path) -> None:
        self.graph, self.namespace, self.height = graph, namespace, HEIGHTS[namespace]
        folder.mkdir()
        self._table = SimulatedTable(folder, 200)
        x, y, z, *turn = map(float, self._table.camera_pose.split())
        graph.processes.start(
            'imitate_node',
            parameters={
                'weights': str(weights),
                'models_path': str(folder),
                'memory_path': str(folder / 'relations.sqlite3'),
                'camera_pose': ' '.join(map(str, (x, y, z + self.height, *turn))),
                'camera_frame': 'camera',
                'max_age': 0.0,
                'discovery_time': 0.5,
                'num_threads': 1,
                'time_budget': 0.0,
                'num_starts': 1,
                'max_steps': 2,
                'num_proposals': 4,
                'publish_infeasible': True,
            },
            arguments=['-r', f'__ns:={namespace}'],
            name=namespace.strip('/'),
        )
        perception = f'{namespace}/perception_node'
        self._clouds = graph.node.create_publisher(
            PointCloud2, f'{perception}/points', qos.latest_cloud(is_reliable=True)
        )
        self._tracks = graph.node.create_publisher(
            TrackedObjectArray, f'{perception}/tracked_objects', qos.TRACKED_POSES
        )
        self._stamp_ns = START_NS
        self.targets: list[PoseArray] = []
        graph.subscribe(PoseArray, f'{namespace}/target_poses', self.targets.append, qos.ANSWERS)

    def show(self) -> None:
        """One cloud and the poses of both objects."""
        self._stamp_ns += NS_PER_SEC // 10
        places = {key: (x, y, z + self.height) for key, (x, y, z) in PLACES.items()}
        self._tracks.publish(self._table.tracks(self._stamp_ns, places))
        self._clouds.publish(self._table.cloud(self._stamp_ns))

    def call(self, kind: Any, service: str, /, **fields: Any) -> Any:
        return self.graph.call(kind, f'{self.namespace}/{service}', **fields)

    def scene(self) -> GetScene.Response:
        return self.call(GetScene, 'perception_node/get_scene', object_ids=PAIR)

    def imitate(self) -> Imitate.Response:
        return self.call(Imitate, 'imitate', reference_ids=PAIR, test_ids=PAIR[::-1])


@pytest.fixture(scope='module')
def robots(
    graph: Graph, weights: Path, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Robot, Robot]:
    folder = tmp_path_factory.mktemp('robots')
    first, second = (
        Robot(graph, namespace, folder / namespace.strip('/'), weights) for namespace in HEIGHTS
    )
    return first, second


def test_a_robot_does_not_see_what_another_one_sees(robots: tuple[Robot, Robot]) -> None:
    first, second = robots

    def is_seen() -> bool:
        first.show()
        return bool(first.scene().success)

    first.graph.wait(is_seen, "the first robot's scene", START_SEC)
    # The nodes of the second have started too, alone although the others' are there.
    refused = second.scene()
    assert not refused.success
    assert '/robot2/perception_node/points' in refused.message

    def is_seen_as_well() -> bool:
        second.show()
        return bool(second.scene().success)

    second.graph.wait(is_seen_as_well, "the second robot's scene")
    for robot in robots:
        height = robot.scene().scene.base.pose.position.z
        assert height == pytest.approx(PLACES['box'][2] + robot.height, abs=0.02)


def test_answers_and_targets_are_of_the_robot_that_was_asked(robots: tuple[Robot, Robot]) -> None:
    for robot in robots:
        answers = robot.imitate().answers
        assert answers
        robot.graph.wait(lambda: bool(robot.targets), 'targets')  # noqa: B023
        target = answers[0].targets[1].target.pose.position
        (published,) = robot.targets
        assert published.poses[1].position.z == pytest.approx(target.z)
        # Half a metre is far more than an object is lifted.
        assert abs(published.poses[0].position.z - robot.height) < 0.25
    assert [len(robot.targets) for robot in robots] == [1, 1]


def test_a_robot_does_not_remember_what_another_one_was_told(robots: tuple[Robot, Robot]) -> None:
    first, second = robots
    told = first.call(Remember, 'metric_node/remember', name='beside', object_ids=PAIR)
    assert told.success, told.message
    assert list(first.call(ListRelations, 'metric_node/list').names) == ['beside']
    assert list(second.call(ListRelations, 'metric_node/list').names) == []
