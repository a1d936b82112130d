"""Parameters are checked whenever they are set."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import pytest
import rclpy
import yaml
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.nodes.imitate_parameters import IMITATE_PARAMETERS
from spatial_relations_ros.nodes.metric_node import METRIC_PARAMETERS
from spatial_relations_ros.nodes.panel_parameters import PANEL_PARAMETERS
from spatial_relations_ros.nodes.perception_parameters import (
    PERCEPTION_PARAMETERS,
    ordered_pairs,
)
from spatial_relations_ros.ros.domains import free_domain_id
from spatial_relations_ros.ros.parameters import Parameters, ParameterSpec

SPECS = (
    ParameterSpec('budget', 5.0, 'Seconds.', minimum=0.0, maximum=60.0),
    ParameterSpec('count', 3, 'How many.', minimum=1, maximum=9),
    ParameterSpec('mode', 'auto', 'How.', choices=('auto', 'true', 'false')),
    ParameterSpec('topics', [], 'Which.'),
    ParameterSpec('places', [], 'Where to.', is_numbers=True),
    ParameterSpec('height', math.nan, 'Where.', minimum=-1.0, maximum=1.0, may_be_nan=True),
    ParameterSpec('name', 'x', 'Who.', is_fixed=True),
)


@pytest.fixture(scope='module')
def context() -> Iterator[Context]:
    context = Context()
    rclpy.init(context=context, domain_id=free_domain_id())
    yield context
    rclpy.shutdown(context=context)


def make(context: Context, *overrides: str) -> tuple[Node, Parameters]:
    arguments = ['--ros-args', *(part for item in overrides for part in ('-p', item))]
    node = Node('parameters', context=context, cli_args=arguments)
    return node, Parameters(node, SPECS)


def set_one(node: Node, name: str, value: object) -> str:
    """Empty when accepted, otherwise the reason."""
    result = node.set_parameters([Parameter(name, value=value)])[0]
    return '' if result.successful else result.reason or 'refused'


def test_defaults_and_overrides(context: Context) -> None:
    node, parameters = make(context, 'budget:=7', 'mode:=true', "topics:=['/a','']")
    assert parameters.number('budget') == 7.0
    assert parameters.text('mode') == 'true'
    assert parameters.texts('topics') == ['/a']
    assert parameters.integer('count') == 3
    assert math.isnan(parameters.number('height'))
    assert parameters.numbers('places') == []
    node.destroy_node()


def test_bad_values_are_refused_with_a_reason_and_change_nothing(context: Context) -> None:
    node, parameters = make(context)
    assert 'budget' in set_one(node, 'budget', -1.0)
    assert 'nan' in set_one(node, 'budget', math.nan)
    assert 'expected a number' in set_one(node, 'budget', 'long')
    assert 'count' in set_one(node, 'count', 10)
    assert 'expected an integer' in set_one(node, 'count', True)
    assert 'one of auto, true, false' in set_one(node, 'mode', 'perhaps')
    assert 'list of strings' in set_one(node, 'topics', [1, 2])
    assert 'finite numbers' in set_one(node, 'places', [1.0, math.nan])
    assert 'finite numbers' in set_one(node, 'places', ['a'])
    assert set_one(node, 'places', [1, 2]) == ''
    assert parameters.numbers('places') == [1.0, 2.0]
    assert 'height' in set_one(node, 'height', 2.0)
    assert set_one(node, 'name', 'y')
    assert parameters.number('budget') == 5.0
    assert parameters.text('name') == 'x'
    assert set_one(node, 'height', 0.5) == ''
    assert parameters.number('height') == 0.5
    node.destroy_node()


def test_a_bad_override_is_a_clear_error(context: Context) -> None:
    node = Node('bad', context=context, cli_args=['--ros-args', '-p', 'budget:=-3.0'])
    with pytest.raises(ConfigError, match='budget'):
        Parameters(node, SPECS)
    node.destroy_node()


def test_descriptors_tell_range_and_purpose(context: Context) -> None:
    node, _ = make(context)
    descriptor = node.describe_parameter('budget')
    assert descriptor.description == 'Seconds.'
    assert descriptor.floating_point_range[0].to_value == 60.0
    assert node.describe_parameter('count').integer_range[0].from_value == 1
    assert 'auto' in node.describe_parameter('mode').additional_constraints
    assert node.describe_parameter('name').read_only
    node.destroy_node()


@pytest.mark.parametrize(
    ('name', 'specs'),
    [
        ('perception_node', PERCEPTION_PARAMETERS),
        ('metric_node', METRIC_PARAMETERS),
        ('imitate_node', IMITATE_PARAMETERS),
        ('panel_node', PANEL_PARAMETERS),
    ],
)
def test_configuration_files_hold_every_parameter_at_its_default(
    name: str, specs: tuple[ParameterSpec, ...]
) -> None:
    path = Path(__file__).resolve().parents[2] / 'config' / f'{name}.yaml'
    values = yaml.safe_load(path.read_text())[f'/**/{name}']['ros__parameters']
    assert set(values) == {spec.name for spec in specs}
    for spec in specs:
        value = spec.checked(values[spec.name])
        both_nan = isinstance(value, float) and math.isnan(value)
        assert both_nan or value == spec.default, spec.name
        assert spec.description.endswith('.')


def test_pairs() -> None:
    assert ordered_pairs(['plate/cup', 'cup/plate']) == [('plate', 'cup'), ('cup', 'plate')]
    for entry in ('plate', 'cup/cup', '/cup'):
        with pytest.raises(ConfigError, match='pairs'):
            ordered_pairs([entry])
