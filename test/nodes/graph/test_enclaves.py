"""config/sros2_policy.xml allows what the running nodes have on the graph, and nothing else."""

from __future__ import annotations

from fnmatch import fnmatchcase
from xml.etree import ElementTree

import pytest
from demo_session import DemoSession
from rclpy.action import (
    get_action_client_names_and_types_by_node,
    get_action_server_names_and_types_by_node,
)
from rclpy.node import Node

from spatial_relations_ros.core import share_path

pytestmark = pytest.mark.ros

NODES = ('perception_node', 'metric_node', 'imitate_node', 'panel_node')
# Where the package is not installed perception does not listen to it.
NEEDS_VISION_MSGS = '/detections'
# What was configured in this session alone: a user adds such topics to the policy.
OF_THIS_SESSION = {'/simtrack/mug'}
ACTION_PARTS = '/_action/'

Rules = dict[str, set[str]]


def allowed_rules(profile: ElementTree.Element) -> Rules:
    """Full names by what may be done with them: publish, subscribe, reply, request, ..."""
    namespace, node = profile.attrib['ns'].rstrip('/'), profile.attrib['node']
    rules: Rules = {}
    for group in profile:
        ((verb, qualifier),) = group.attrib.items()
        assert qualifier == 'ALLOW'
        for item in group:
            name = (item.text or '').replace('~', node, 1)
            full = name if name.startswith('/') else f'{namespace}/{name}'
            rules.setdefault(verb, set()).add(full)
    return rules


def used_rules(client: Node, name: str) -> Rules:
    """What a running node has; the topics and services of actions count as the actions."""
    found = {
        'publish': client.get_publisher_names_and_types_by_node(name, '/'),
        'subscribe': client.get_subscriber_names_and_types_by_node(name, '/'),
        'reply': client.get_service_names_and_types_by_node(name, '/'),
        'request': client.get_client_names_and_types_by_node(name, '/'),
        'execute': get_action_server_names_and_types_by_node(client, name, '/'),
        'call': get_action_client_names_and_types_by_node(client, name, '/'),
    }
    rules = {
        verb: {full for full, _ in names if ACTION_PARTS not in full} - OF_THIS_SESSION
        for verb, names in found.items()
    }
    return {verb: names for verb, names in rules.items() if names}


@pytest.fixture(scope='module')
def profiles() -> dict[str, ElementTree.Element]:
    """The only profile of each enclave, by its path."""
    root = ElementTree.parse(share_path('config', 'sros2_policy.xml')).getroot()
    assert (root.tag, root.attrib) == ('policy', {'version': '0.2.0'})
    found = {}
    for enclave in root.iterfind('enclaves/enclave'):
        (found[enclave.attrib['path']],) = enclave.iterfind('profiles/profile')
    return found


@pytest.fixture(scope='module')
def client(session: DemoSession, panel_address: str) -> Node:
    """Of the graph in which all nodes run and targets were published."""
    if not session.single_targets:
        session.imitate()
        session.graph.wait(lambda: bool(session.single_targets), 'targets')
    return session.graph.node


def test_each_node_runs_in_the_enclave_that_the_policy_has_for_it(
    client: Node, profiles: dict[str, ElementTree.Element]
) -> None:
    running = {
        name: path for name, _, path in client.get_node_names_and_namespaces_with_enclaves()
    }
    assert {running[name]: name for name in NODES} == {
        path: profile.attrib['node'] for path, profile in profiles.items()
    }


@pytest.mark.parametrize('name', NODES)
def test_the_policy_allows_what_the_node_does_and_nothing_else(
    client: Node, profiles: dict[str, ElementTree.Element], name: str
) -> None:
    allowed, used = allowed_rules(profiles[f'/{name}']), used_rules(client, name)
    assert set(used) == set(allowed)
    for verb, names in used.items():
        denied = {n for n in names if not any(fnmatchcase(n, rule) for rule in allowed[verb])}
        assert denied == set(), f'the policy denies to {verb}'
        idle = {rule for rule in allowed[verb] if not any(fnmatchcase(n, rule) for n in names)}
        assert idle <= {NEEDS_VISION_MSGS}, f'the policy needlessly allows to {verb}'
