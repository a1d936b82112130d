"""More requests at once than anybody can serve, and more cancels."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from ros_graph import ANSWER_SEC, Graph
from spatial_relations_msgs.action import ImitateRelation
from spatial_relations_msgs.srv import Distance, GetScene, Imitate

from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.waiting import wait_for

from .conftest import Faults
from .three_nodes import PAIR, ThreeNodes

pytestmark = pytest.mark.ros

NUM_REQUESTS = 50
ENDED = (GoalStatus.STATUS_CANCELED, GoalStatus.STATUS_ABORTED, GoalStatus.STATUS_SUCCEEDED)


@pytest.fixture(scope='module')
def nodes(graph: Graph, weights: Path, tmp_path_factory: pytest.TempPathFactory) -> ThreeNodes:
    folder = tmp_path_factory.mktemp('storm')
    return ThreeNodes(graph, folder / 'models', weights, folder / 'memory.sqlite3')


def storm(graph: Graph, kind: Any, service: str, **fields: Any) -> list[Any]:
    """The answers to fifty requests at once.

    The client's queue is as long: with the default of ten DDS drops answers that the client has
    not taken yet, whichever node they come from.
    """
    client = graph.node.create_client(kind, service, qos_profile=qos.REQUESTS)
    graph.wait(client.service_is_ready, service)
    futures = [client.call_async(kind.Request(**fields)) for _ in range(NUM_REQUESTS)]
    answers = [wait_for(future, ANSWER_SEC) for future in futures]
    graph.node.destroy_client(client)
    return answers


@pytest.mark.parametrize(
    ('kind', 'service', 'fields'),
    [
        (GetScene, '/perception_node/get_scene', {'object_ids': PAIR}),
        (Distance, '/metric_node/distance', {'reference_ids': PAIR, 'test_ids': PAIR[::-1]}),
        (Imitate, '/imitate', {'reference_ids': PAIR, 'test_ids': PAIR[::-1]}),
    ],
)
def test_each_of_fifty_requests_is_answered(
    nodes: ThreeNodes, faults: Faults, kind: Any, service: str, fields: dict[str, Any]
) -> None:
    with faults(f'{NUM_REQUESTS} parallel requests to {service}') as row:
        answers = storm(nodes.graph, kind, service, **fields)
        row.is_over()
        refused = [answer.message for answer in answers if not answer.success]
        busy = [message for message in refused if 'try again later' in message]
        if kind is not Imitate:  # untrained weights need not find a good imitation
            assert refused == busy
        assert len(busy) < NUM_REQUESTS
        row.said = f'{NUM_REQUESTS - len(busy)} served'
        if busy:
            row.said += f', {len(busy)} answered "{busy[0]}"'
        assert nodes.imitate().answers  # as ever
        row.is_back()


def test_a_storm_of_cancels(nodes: ThreeNodes, faults: Faults) -> None:
    client = ActionClient(
        nodes.graph.node,
        ImitateRelation,
        '/imitate_relation',
        goal_service_qos_profile=qos.REQUESTS,
        result_service_qos_profile=qos.REQUESTS,
        cancel_service_qos_profile=qos.REQUESTS,
    )
    nodes.graph.wait(client.server_is_ready, 'the action')
    goal = ImitateRelation.Goal(reference_ids=PAIR, test_ids=PAIR[::-1], time_budget=600.0)
    with faults(f'{NUM_REQUESTS} goals at once, each cancelled twice') as row:
        send = nodes.graph.sent
        sent = [send(lambda: client.send_goal_async(goal)) for _ in range(NUM_REQUESTS)]
        handles = [wait_for(future, ANSWER_SEC) for future in sent]
        assert all(handle.accepted for handle in handles)
        cancels = [send(handle.cancel_goal_async) for handle in [*handles, *handles[::-1]]]
        for cancel in cancels:
            wait_for(cancel, ANSWER_SEC)
        results = [send(handle.get_result_async) for handle in handles]
        outcomes = [wait_for(result, ANSWER_SEC) for result in results]
        row.is_over()
        statuses = Counter(outcome.status for outcome in outcomes)
        ended = (
            GoalStatus.STATUS_CANCELED,
            GoalStatus.STATUS_ABORTED,
            GoalStatus.STATUS_SUCCEEDED,
        )
        assert sum(statuses[status] for status in ended) == NUM_REQUESTS
        messages = Counter(outcome.result.message for outcome in outcomes)
        row.said = ', '.join(f'{n} x "{text}"' for text, n in messages.most_common(3))
        assert nodes.imitate().answers
        row.is_back()
    client.destroy()


def test_memory_did_not_grow(nodes: ThreeNodes) -> None:
    def memory_mb() -> dict[str, float]:
        return {
            name: float(nodes.graph.diagnostic(f'{name}: process')['memory_mb'])
            for name in ('perception_node', 'metric_node', 'imitate_node')
        }

    before = memory_mb()
    for _ in range(3):
        storm(
            nodes.graph, Distance, '/metric_node/distance', reference_ids=PAIR, test_ids=PAIR[::-1]
        )
    after = memory_mb()
    assert all(after[name] - before[name] < 100.0 for name in before), (before, after)
