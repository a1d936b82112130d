"""What imitate_node is told of the robot."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
import pytest
import rclpy
from geometry_msgs.msg import TransformStamped
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from tf2_msgs.msg import TFMessage

from spatial_relations_ros.core import (
    CloudSource,
    ConfigError,
    FrameTransformError,
    Pose,
    Scene,
    SceneObject,
)
from spatial_relations_ros.imitation import ImitationOptions
from spatial_relations_ros.nodes.robot_parameters import (
    ROBOT_PARAMETERS,
    Robot,
    grasp_frames,
    grasps,
    obstacles_of,
    shoulder_positions,
)
from spatial_relations_ros.nodes.scene_client import SeenScene
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.domains import free_domain_id
from spatial_relations_ros.ros.relations_node import RelationsNode
from spatial_relations_ros.ros.waiting import wait_until

POINTS = np.random.default_rng(0).uniform(-0.05, 0.05, (200, 3)).astype(np.float32)


def seen(**more: object) -> SeenScene:
    tray = SceneObject('tray', POINTS, Pose(np.array([1.0, 0.0, 0.0])))
    mug = SceneObject('mug', POINTS, Pose(np.array([2.0, 0.0, 0.0])))
    scene = Scene(tray, mug, stamp_ns=5, frame_id='map')
    return dataclasses.replace(SeenScene(scene), **more)  # type: ignore[arg-type]


def test_grasps_are_in_the_order_of_ros() -> None:
    found = grasps(['mug=0 0 0.1 1 0 0 0', 'bowl = 0.2, 0, 0, 0, 0, 0, 1'])
    np.testing.assert_allclose(found['mug'].quat_wxyz, [0, 1, 0, 0])
    np.testing.assert_allclose(found['mug'].translation, [0, 0, 0.1])
    np.testing.assert_allclose(found['bowl'].quat_wxyz, [1, 0, 0, 0])


@pytest.mark.parametrize(
    'entry',
    ['mug', 'mug=', '=0 0 0 0 0 0 1', 'mug=0 0 0', 'mug=0 0 0 0 0 0 0', 'mug=a b c d e f g'],
)
def test_a_bad_grasp_says_what_is_expected(entry: str) -> None:
    with pytest.raises(ConfigError, match='x y z qx qy qz qw'):
        grasps([entry])


def test_grasp_frames_and_shoulders() -> None:
    assert grasp_frames(['mug=l_gripper', 'cup = r']) == {'mug': 'l_gripper', 'cup': 'r'}
    with pytest.raises(ConfigError, match='mug=frame'):
        grasp_frames(['mug'])
    assert shoulder_positions([]).shape == (0, 3)
    np.testing.assert_array_equal(shoulder_positions([1, 2, 3, 4, 5, 6])[1], [4, 5, 6])
    with pytest.raises(ConfigError, match='4 numbers'):
        shoulder_positions([1, 2, 3, 4])


def test_everything_else_is_an_obstacle() -> None:
    jar = SceneObject('jar', POINTS, Pose(np.array([0.5, 0, 0])), CloudSource.OBSERVED)
    clutter = np.array([[0.0, 0.0, 0.1 + 0.01 * k] for k in range(5)], dtype=np.float32)
    found = obstacles_of(seen(others=(jar,), clutter=clutter))
    assert [item.name for item in found] == ['jar', 'something unknown']
    assert abs(found[0].points.mean(axis=0)[0] - 0.5) < 0.02
    # Single points are taken for noise of the camera.
    for stray in (clutter[:0], clutter[:1], clutter * [1, 1, 10]):
        assert obstacles_of(seen(clutter=stray)) == ()


class Nodes:
    """A node with the robot's parameters, spinning beside a publisher of transforms."""

    def __init__(self) -> None:
        self.context = Context()
        rclpy.init(context=self.context, domain_id=free_domain_id())
        self.executor = SingleThreadedExecutor(context=self.context)
        self.made: list[RelationsNode] = []

    def robot(self, *overrides: str) -> Robot:
        arguments = ['--ros-args', *(part for item in overrides for part in ('-p', item))]
        node = RelationsNode('robot', ROBOT_PARAMETERS, context=self.context, cli_args=arguments)
        self.made.append(node)
        self.executor.add_node(node)
        return Robot(node)

    def close(self) -> None:
        self.executor.shutdown()
        for node in self.made:
            node.destroy_node()
        rclpy.shutdown(context=self.context)


@pytest.fixture
def nodes() -> Iterator[Nodes]:
    nodes = Nodes()
    yield nodes
    nodes.close()


def test_without_parameters_there_is_no_arm_and_no_grasp(nodes: Nodes) -> None:
    options = nodes.robot().options(ImitationOptions(), seen())
    assert (options.arm, dict(options.grasps), options.obstacles) == (None, {}, ())


def test_shoulders_and_grasps_of_parameters(nodes: Nodes) -> None:
    robot = nodes.robot(
        'shoulder_positions:=[0.0, 0.2, 0.8, 0.0, -0.2, 0.8]', 'reach_max:=0.9',
        "grasps:=['mug=0 0 0.1 0 0 0 1']",
    )  # fmt: skip
    jar = SceneObject('jar', POINTS, Pose())
    options = robot.options(ImitationOptions(), seen(others=(jar,)))
    assert options.arm is not None
    assert options.arm.shoulders.tolist() == [[0.0, 0.2, 0.8], [0.0, -0.2, 0.8]]
    assert (options.arm.nearest, options.arm.farthest) == (0.25, 0.9)
    assert list(options.grasps) == ['mug']
    assert [item.name for item in options.obstacles] == ['jar']


def test_obstacles_can_be_switched_off(nodes: Nodes) -> None:
    robot = nodes.robot('avoid_others:=false')
    assert not robot.avoids_others
    assert robot.options(ImitationOptions(), seen(others=(seen().scene.base,))).obstacles == ()


def test_frames_are_looked_up(nodes: Nodes) -> None:
    robot = nodes.robot("shoulder_frames:=['shoulder']", "grasp_frames:=['mug=tool']")
    with pytest.raises(FrameTransformError, match='shoulder'):
        robot.options(ImitationOptions(), seen())
    publisher = nodes.made[0].create_publisher(TFMessage, '/tf_static', qos.STATIC_TRANSFORMS)
    transforms = []
    for child, x in (('shoulder', 0.5), ('tool', 2.3)):
        transform = TransformStamped(child_frame_id=child)
        transform.header.frame_id = 'map'
        transform.transform.translation.x = x
        transforms.append(transform)
    publisher.publish(TFMessage(transforms=transforms))

    def is_known() -> bool:
        nodes.executor.spin_once(timeout_sec=0.1)
        try:
            robot.options(ImitationOptions(), seen())
        except FrameTransformError:
            return False
        return True

    assert wait_until(is_known, 60.0)
    options = robot.options(ImitationOptions(), seen())
    assert options.arm is not None
    assert options.arm.shoulders.tolist() == [[0.5, 0.0, 0.0]]
    # The tool is 0.3 m beside the mug now.
    np.testing.assert_allclose(options.grasps['mug'].translation, [0.3, 0, 0], atol=1e-12)


@pytest.mark.parametrize(
    ('override', 'message'),
    [
        ('shoulder_positions:=[1.0, 2.0]', '2 numbers'),
        ("shoulder_positions:=['a']", 'finite numbers'),
        ("grasps:=['mug']", 'grasps has'),
        ("grasp_frames:=['mug']", 'grasp_frames has'),
        ('reach_min:=-1.0', 'reach_min'),
    ],
)
def test_parameters_that_cannot_be_used(nodes: Nodes, override: str, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        nodes.robot(override)
