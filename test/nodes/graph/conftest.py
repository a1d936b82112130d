"""Three nodes as processes and the recorded bag over DDS, once for all files of this folder."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from demo_session import DemoSession
from ros_graph import START_SEC, Graph, running_graph
from spatial_relations_msgs.srv import ListRelations

from spatial_relations_ros.nodes.bag_player import BagPlayer
from spatial_relations_ros.nodes.demo_plan import read_demo_plan

CAMERA_FRAME = 'kinect2_ir_optical_frame'


@pytest.fixture(scope='package')
def graph(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Graph]:
    yield from running_graph(tmp_path_factory.mktemp('graph'))


@pytest.fixture(scope='package')
def session(
    graph: Graph, bags: Path, weights: Path, tmp_path_factory: pytest.TempPathFactory
) -> DemoSession:
    plan = read_demo_plan(bags / 'demo.yaml')
    memory = tmp_path_factory.mktemp('memory') / 'relations.sqlite3'
    models = str(plan.models_path)
    graph.processes.start(
        'perception_node',
        parameters={
            'models_path': models,
            'reliable_points': True,
            'publish_rate': 2.0,
            'find_clutter': True,
            'max_age': 0.0,
            # A second source of poses; the model is that of `mug`.
            'pose_topics': ['mug_2=/simtrack/mug'],
        },
        remappings={
            '~/points': plan.points_topic,
            '~/tracked_objects': plan.tracked_objects_topic,
            '~/detections': '/detections',
        },
        arguments=['--enclave', '/perception_node'],
    )
    graph.processes.start(
        'metric_node',
        parameters={'weights': str(weights), 'memory_path': str(memory)},
        arguments=['--enclave', '/metric_node'],
    )
    graph.processes.start(
        'imitate_node',
        parameters={
            'weights': str(weights),
            'models_path': models,
            'standalone': False,
            # The steps end a request, not the clock: the same on a busy machine.
            'time_budget': 0.0,
            'num_starts': 2,
            'max_steps': 4,
            'publish_infeasible': True,
            # How the gripper holds what is moved.
            'grasps': [f'{plan.imitations[0].test_ids[1]}=0 0 0.1 1 0 0 0'],
        },
        arguments=['--enclave', '/imitate_node'],
    )
    session = DemoSession(graph, plan)
    graph.call(ListRelations, '/metric_node/list')
    player = BagPlayer(graph.node, plan.bag)
    graph.wait(lambda: graph.node.count_subscribers(plan.points_topic) >= 2, 'perception')
    player.wait_for_subscribers([plan.points_topic, plan.tracked_objects_topic], START_SEC)
    assert player.play() == sum(count for _, count in player.contents.values())
    pair = (session.reference_ids[0], session.reference_ids[1])
    graph.wait(lambda: session.scenes[pair] > 0, 'a scene of the demonstration')
    session.is_playing = False
    return session


@pytest.fixture(scope='package')
def panel_address(session: DemoSession) -> str:
    """Where the panel of this session is."""
    graph = session.graph
    graph.processes.start(
        'panel_node',
        parameters={
            'port': 0,
            'models_path': str(session.plan.models_path),
            'camera_frame': CAMERA_FRAME,
        },
        arguments=['--enclave', '/panel_node'],
    )
    name = 'panel_node: panel'
    graph.wait(lambda: graph.diagnostic(name)['message'].startswith('http'), 'panel', START_SEC)
    return graph.diagnostic(name)['message']
