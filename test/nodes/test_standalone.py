"""imitate_node alone, in a namespace, with weights that are missing, damaged, and good."""

from __future__ import annotations

import json
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from ros_graph import ANSWER_SEC, Graph
from spatial_relations_msgs.msg import Scene as SceneMsg
from spatial_relations_msgs.srv import Embed, GetScene, Imitate, ListRelations

from spatial_relations_ros.core import Pose, Scene, SceneObject
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.conversions import scene_to_msg
from spatial_relations_ros.ros.waiting import wait_for

pytestmark = pytest.mark.ros

NAMESPACE = '/robot'


@pytest.fixture(scope='module')
def alone(graph: Graph, tmp_path_factory: pytest.TempPathFactory) -> Graph:
    folder = tmp_path_factory.mktemp('alone')
    graph.processes.start(
        'imitate_node',
        parameters={
            'weights': str(folder / 'absent.safetensors'),
            'memory_path': str(folder / 'relations.sqlite3'),
            'discovery_time': 0.5,
            'time_budget': 0.0,
            'num_starts': 1,
            'max_steps': 1,
        },
        # A name for this node alone: the two that it starts keep theirs.
        arguments=['-r', f'__ns:={NAMESPACE}', '-r', '__node:=imitator'],
    )
    return graph


def make_scene(names: tuple[str, str], offset: float) -> SceneMsg:
    rng = np.random.default_rng(0)
    objects = [
        SceneObject(
            name,
            rng.uniform(-0.05, 0.05, (400, 3)).astype(np.float32),
            Pose(np.array([offset * idx, 0.0, 0.05])),
        )
        for idx, name in enumerate(names)
    ]
    return scene_to_msg(Scene(objects[0], objects[1]))


def imitate(graph: Graph) -> Any:
    return graph.call(
        Imitate,
        f'{NAMESPACE}/imitate',
        reference_scene=[make_scene(('plate', 'cup'), 0.12)],
        test_scene=[make_scene(('tray', 'mug'), 0.5)],
    )


def use_weights(graph: Graph, path: Path) -> None:
    value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=str(path))
    response = graph.call(
        SetParameters,
        f'{NAMESPACE}/imitator/set_parameters',
        parameters=[Parameter(name='weights', value=value)],
    )
    assert response.results[0].successful


def test_missing_weights_are_said_to_the_client(alone: Graph) -> None:
    response = imitate(alone)
    assert not response.success
    assert 'absent.safetensors does not exist' in response.message
    assert not response.answers
    name = 'robot/imitator: model'
    alone.wait(lambda: 'does not exist' in alone.diagnostic(name)['message'], 'diagnostics')
    assert alone.diagnostic(name)['level'] == '2'


def test_damaged_weights_are_said_to_the_client(
    alone: Graph, weights: Path, tmp_path: Path
) -> None:
    damaged = tmp_path / 'damaged.safetensors'
    content = bytearray(weights.read_bytes())
    content[-1] ^= 1
    damaged.write_bytes(content)
    card = json.loads(weights.with_suffix('.json').read_text())
    damaged.with_suffix('.json').write_text(json.dumps(card))
    use_weights(alone, damaged)
    response = imitate(alone)
    assert not response.success
    assert 'damaged.safetensors is damaged' in response.message
    assert 'SHA-256' in response.message


def test_good_weights_heal_it_without_a_restart(alone: Graph, weights: Path) -> None:
    use_weights(alone, weights)
    response = imitate(alone)
    assert response.answers, response.message
    assert [item.object_id for item in response.answers[0].targets] == ['tray', 'mug']


def test_perception_and_metric_run_in_its_process(alone: Graph) -> None:
    name = 'robot/imitator: standalone'
    alone.wait(lambda: alone.diagnostic(name)['message'].startswith('on'), 'standalone')
    seen = alone.call(
        GetScene, f'{NAMESPACE}/perception_node/get_scene', object_ids=['plate', 'cup']
    )
    assert not seen.success
    assert 'no point cloud' in seen.message
    assert f'{NAMESPACE}/perception_node/points' in seen.message
    assert alone.call(ListRelations, f'{NAMESPACE}/metric_node/list').success
    scene = make_scene(('plate', 'cup'), 0.12)
    assert alone.call(Embed, f'{NAMESPACE}/metric_node/embed', scene=[scene]).success


def test_ids_without_a_camera_are_answered(alone: Graph) -> None:
    response = alone.call(
        Imitate, f'{NAMESPACE}/imitate', reference_ids=['a', 'b'], test_ids=['c', 'd']
    )
    assert not response.success
    assert 'no point cloud' in response.message


def test_a_scene_in_another_frame_is_refused(alone: Graph) -> None:
    scene = make_scene(('plate', 'cup'), 0.12)
    scene.header.frame_id = 'camera'
    imitated = alone.call(
        Imitate, f'{NAMESPACE}/imitate', reference_scene=[scene], test_ids=['c', 'd']
    )
    embedded = alone.call(Embed, f'{NAMESPACE}/metric_node/embed', scene=[scene])
    for response in (imitated, embedded):
        assert not response.success
        assert "'camera'" in response.message
        assert "'world'" in response.message


def test_each_of_many_requests_at_once_is_answered(alone: Graph) -> None:
    """Each needs an answer of perception, on another thread of the same process."""
    client = alone.node.create_client(Imitate, f'{NAMESPACE}/imitate', qos_profile=qos.REQUESTS)
    alone.wait(client.service_is_ready, 'imitate')
    request = Imitate.Request(reference_ids=['a', 'b'], test_ids=['c', 'd'])
    futures = [client.call_async(request) for _ in range(30)]
    messages = [wait_for(future, ANSWER_SEC).message for future in futures]
    served = [message for message in messages if 'no point cloud' in message]
    refused = [message for message in messages if 'being served already' in message]
    assert served
    assert len(served) + len(refused) == len(messages)
    alone.node.destroy_client(client)


def test_two_interrupts_end_it_cleanly(alone: Graph) -> None:
    """Under a launcher Ctrl-C arrives twice. The last test of this graph."""
    process = alone.processes.process('imitate_node')
    process.send_signal(signal.SIGINT)
    process.send_signal(signal.SIGINT)
    assert process.wait(30.0) == 0
    printed = alone.processes.log_path('imitate_node').read_text()
    assert 'Traceback' not in printed
    assert '\n[' not in printed.replace('\n[INFO]', '').replace('\n[WARN]', '')
