"""A bag through the graph: what live nodes make of it, and how it is published."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ros_graph import START_SEC, Graph
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2
from spatial_relations_msgs.msg import Scene as SceneMsg
from spatial_relations_msgs.msg import TrackedObjectArray

from spatial_relations_ros.core import executable_path
from spatial_relations_ros.evaluation.bag_reader import BagReader
from spatial_relations_ros.evaluation.bag_types import package_typestore
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


def kill_all_of(process: subprocess.Popen[Any]) -> None:
    """What is left of a process in a session of its own, and of those that it started."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)


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
    # With SIGINT ignored, as a background job of a script starts it.
    command = ['sh', '-c', 'trap "" INT; exec "$@"', 'sh']
    command += relations(plan.bag, '--publish', '--rate', 8, '--loop', '--clock')
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        try:
            graph.wait(lambda: any(np.diff(stamps) < 0), 'a second time', START_SEC)
            graph.wait(lambda: any(np.diff(clock) < 0), 'a clock that begins anew')
            # More often than there are messages' times, so that timers go on.
            graph.wait(lambda: len(set(clock)) > 50, 'a clock between the messages')
            graph.wait(lambda: bool(tracked), 'tracked poses')
            process.send_signal(signal.SIGINT)
            printed, _ = process.communicate(timeout=60.0)
        finally:
            kill_all_of(process)
    assert process.returncode == 0
    assert f'messages on {plan.points_topic}' in printed
    with BagReader(plan.bag) as reader:
        clouds = {frame.stamp_ns for frame in reader.frames()}
        first_ns, last_ns = reader.start_ns, reader.start_ns + reader.duration_ns
    assert set(stamps) <= clouds
    slack_ns = 2_000_000_000
    assert first_ns - slack_ns <= min(clock) <= max(clock) <= last_ns + slack_ns


def test_a_termination_of_the_command_ends_its_player(graph: Graph, plan: DemoPlan) -> None:
    def count() -> int:
        return graph.node.count_publishers(plan.points_topic)

    before = count()
    command = relations(plan.bag, '--publish', '--loop')
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, start_new_session=True) as process:
        try:
            graph.wait(lambda: count() > before, 'the player', START_SEC)
            process.terminate()
            assert process.wait(60.0) == 0
        finally:
            kill_all_of(process)
    graph.wait(lambda: count() == before, 'the end of the player')


# The shipped bag is of mcap, compressed.
STORAGES = {
    'mcap': (StoragePlugin.MCAP, None),
    'sqlite3': (StoragePlugin.SQLITE3, None),
    'sqlite3-zstd': (StoragePlugin.SQLITE3, CompressionMode.FILE),
}


def write_first_tracks(
    source: Path, topic: str, to: Path, storage: str, *, as_topic: str
) -> list[bytes]:
    """A bag of one topic's first ten messages, under another name."""
    plugin, compression = STORAGES[storage]
    writer = Writer(to, version=9, storage_plugin=plugin)
    if compression is not None:
        writer.set_compression(compression, CompressionFormat.ZSTD)
    with BagReader(source) as reader, writer:
        connection = writer.add_connection(
            as_topic, reader.contents[topic][0], typestore=package_typestore()
        )
        messages = islice((item for item in reader.raw() if item.topic == topic), 10)
        contents = []
        for message in messages:
            writer.write(connection, message.time_ns, message.data)
            contents.append(message.data)
    return contents


@pytest.mark.parametrize('storage', STORAGES)
def test_the_player_of_the_launch_file_plays_every_storage_from_the_start(
    graph: Graph, plan: DemoPlan, tmp_path: Path, storage: str
) -> None:
    """It waits for whoever listens, so that nothing of a bag that is played once is missed."""
    # Of its own: the player must not take the perception node for the listener of this test.
    topic = f'/played_from_{storage.replace("-", "_")}'
    tracks = plan.tracked_objects_topic
    written = write_first_tracks(plan.bag, tracks, tmp_path / 'bag', storage, as_topic=topic)
    heard: list[bytes] = []
    subscription = graph.node.create_subscription(
        TrackedObjectArray, topic, heard.append, qos.TRANSFORMS, raw=True
    )
    command = [str(executable_path('play_bag')), str(tmp_path / 'bag'), '--rate', '20']
    command += ['--wait', '60', '--wait-for', topic]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=90.0)
    assert done.returncode == 0, done.stderr
    graph.wait(lambda: len(heard) >= len(written), 'all messages')
    graph.node.destroy_subscription(subscription)
    assert heard == written


def test_a_topic_to_wait_for_that_the_bag_lacks_is_named(plan: DemoPlan) -> None:
    command = [str(executable_path('play_bag')), str(plan.bag), '--wait', '1', '--wait-for', '/x']
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=90.0)
    assert done.returncode == 2
    assert 'nothing is published on /x; topics of the bag: ' in done.stderr
    assert plan.points_topic in done.stderr


def test_a_termination_ends_the_wait_for_subscribers(graph: Graph, plan: DemoPlan) -> None:
    graph.processes.start(
        'play_bag',
        remappings={plan.points_topic: '/unheard'},
        arguments=['--', str(plan.bag), '--wait', '600'],
    )
    graph.wait(lambda: graph.node.count_publishers('/unheard') > 0, 'the player', START_SEC)
    assert graph.processes.end('play_bag', signal.SIGTERM) == 0


def test_a_bag_that_is_none_is_named_by_the_command(tmp_path: Path) -> None:
    done = subprocess.run(
        relations(tmp_path / 'no_bag', '--publish'), capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert 'no_bag is not a bag' in done.stderr
