"""A bag through the graph: what live nodes make of it, and how it is published."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ros_graph import START_SEC, Graph
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2
from spatial_relations_msgs.msg import Scene as SceneMsg
from spatial_relations_msgs.msg import TrackedObjectArray

from spatial_relations_ros.evaluation.bag_reader import BagReader
from spatial_relations_ros.nodes.bag_player import BagPlayer
from spatial_relations_ros.nodes.demo_plan import DemoPlan, read_demo_plan
from spatial_relations_ros.perception.messages import stamp_ns
from spatial_relations_ros.pipeline import LibraryModels, Pipeline
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.conversions import scene_from_msg
from spatial_relations_ros.ros.waiting import wait_until

pytestmark = pytest.mark.ros

PAIR = ('plate', 'cup')
FRAME_SEC = 60.0


@pytest.fixture(scope='module')
def plan(bags: Path) -> DemoPlan:
    return read_demo_plan(bags / 'demo.yaml')


@pytest.fixture(scope='module')
def scenes(graph: Graph, plan: DemoPlan) -> dict[int, SceneMsg]:
    """What a perception node publishes while the bag is played, by stamp."""
    graph.processes.start(
        'perception_node',
        parameters={
            'models_path': str(plan.models_path),
            'reliable_points': True,
            'publish_rate': 100.0,
            'pairs': ['/'.join(PAIR)],
            # On a busy machine poses may come long after their cloud.
            'pose_wait': 10.0,
        },
        remappings={
            '~/points': plan.points_topic,
            '~/tracked_objects': plan.tracked_objects_topic,
        },
    )
    published: dict[int, SceneMsg] = {}
    arrived = threading.Event()

    def on_scene(message: SceneMsg) -> None:
        published[stamp_ns(message.header.stamp)] = message
        arrived.set()

    graph.subscribe(SceneMsg, '/perception_node/scenes', on_scene, qos.SCENES)
    player = BagPlayer(graph.node, plan.bag)
    topics = [plan.points_topic, plan.tracked_objects_topic, '/tf_static']
    player.wait_for_subscribers(topics, START_SEC)
    graph.wait(lambda: graph.node.count_publishers('/perception_node/scenes') > 0, 'scenes')

    def on_cloud(cloud_ns: int) -> None:
        # Only the newest cloud is kept: a busy node must not be overrun here.
        wait_until(lambda: cloud_ns in published, 2.0)

    player.play(after_cloud=on_cloud)
    return published


def test_live_scenes_are_those_of_the_replay(scenes: dict[int, SceneMsg], plan: DemoPlan) -> None:
    """Poses and clouds, in every frame whose cloud has arrived."""
    pipeline = Pipeline(models=LibraryModels(plan.models_path))
    replayed = {}
    with BagReader(plan.bag) as reader:
        for frame in reader.frames():
            result = pipeline.step(frame)
            if set(PAIR) <= set(result.objects):
                replayed[frame.stamp_ns] = result.scene(*PAIR)
    assert len(scenes) >= 0.8 * len(replayed)
    for stamp, message in scenes.items():
        live = scene_from_msg(message)
        for seen, again in zip(live.objects, replayed[stamp].objects, strict=True):
            np.testing.assert_array_equal(seen.points, again.points)
            # Quaternions are normalised again on their way.
            np.testing.assert_allclose(
                seen.world_from_object.as_matrix(), again.world_from_object.as_matrix(), atol=1e-12
            )


def relations(*arguments: object) -> list[str]:
    return [sys.executable, '-m', 'spatial_relations_ros.cli.main', 'replay', *map(str, arguments)]


def test_the_command_publishes_a_bag_with_its_times(graph: Graph, plan: DemoPlan) -> None:
    """Twice as fast, again and again, until it is interrupted; the clock begins anew each time."""
    clock: list[int] = []
    stamps: list[int] = []
    tracked: list[Any] = []
    graph.subscribe(Clock, '/clock', lambda msg: clock.append(stamp_ns(msg.clock)), qos.CLOCK)
    graph.subscribe(
        PointCloud2,
        plan.points_topic,
        lambda msg: stamps.append(stamp_ns(msg.header.stamp)),
        qos.latest_cloud(is_reliable=True),
    )
    graph.subscribe(
        TrackedObjectArray, plan.tracked_objects_topic, tracked.append, qos.TRACKED_POSES
    )
    command = relations(plan.bag, '--publish', '--rate', 8, '--loop', '--clock')
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            graph.wait(lambda: any(np.diff(stamps) < 0), 'a second time', START_SEC)
            graph.wait(lambda: any(np.diff(clock) < 0), 'a clock that begins anew')
        finally:
            process.send_signal(signal.SIGINT)
        printed, _ = process.communicate(timeout=60.0)
    assert process.returncode == 0
    assert f'messages on {plan.points_topic}' in printed
    with BagReader(plan.bag) as reader:
        clouds = {frame.stamp_ns for frame in reader.frames()}
        first_ns, last_ns = reader.start_ns, reader.start_ns + reader.duration_ns
    assert set(stamps) <= clouds
    assert tracked
    slack_ns = 2_000_000_000
    assert first_ns - slack_ns <= min(clock) <= max(clock) <= last_ns + slack_ns
    # More often than there are messages' times, so that timers go on.
    assert len(set(clock)) > 50


def test_a_bag_that_is_none_is_named_by_the_command(tmp_path: Path) -> None:
    done = subprocess.run(
        relations(tmp_path / 'no_bag', '--publish'), capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert 'no_bag is not a bag' in done.stderr
