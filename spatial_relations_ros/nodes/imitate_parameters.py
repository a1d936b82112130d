"""Parameters of imitate_node."""

from __future__ import annotations

import math

from spatial_relations_ros.imitation import ImitationOptions
from spatial_relations_ros.nodes.follow_parameters import FOLLOW_PARAMETERS
from spatial_relations_ros.nodes.model_host import MODEL_PARAMETERS
from spatial_relations_ros.nodes.node_recording import RERUN
from spatial_relations_ros.nodes.perception_parameters import MODELS_PATH
from spatial_relations_ros.nodes.robot_parameters import ROBOT_PARAMETERS
from spatial_relations_ros.nodes.scene_client import SCENE_PARAMETERS
from spatial_relations_ros.ros.parameters import Parameters, ParameterSpec

DEFAULTS = ImitationOptions()

IMITATE_PARAMETERS = (
    *MODEL_PARAMETERS,
    *SCENE_PARAMETERS,
    MODELS_PATH,
    ParameterSpec(
        'metric',
        'metric_node',
        'Name of the metric node, which keeps remembered relations; relative to the namespace.',
        is_fixed=True,
    ),
    ParameterSpec(
        'standalone',
        'auto',
        'Run perception and metric in this process: true, false, or auto: when no other '
        'perception node is found at start.',
        choices=('auto', 'true', 'false'),
        is_fixed=True,
    ),
    ParameterSpec(
        'discovery_time',
        3.0,
        'How long other nodes are looked for before standalone=auto decides, seconds.',
        minimum=0.1,
        maximum=60.0,
        is_fixed=True,
    ),
    ParameterSpec(
        'time_budget',
        10.0,
        'Seconds a request may take when it does not say; 0: no limit.',
        minimum=0.0,
        maximum=3600.0,
    ),
    ParameterSpec(
        'num_proposals',
        DEFAULTS.num_proposals,
        'Placements proposed from the shapes and compared; more find more and take longer.',
        minimum=1,
        maximum=10000,
    ),
    ParameterSpec(
        'num_starts',
        DEFAULTS.num_starts,
        'How many of the nearest placements are refined.',
        minimum=1,
        maximum=100,
    ),
    ParameterSpec(
        'max_steps',
        DEFAULTS.max_steps,
        'Optimization steps of each refinement.',
        minimum=0,
        maximum=10000,
    ),
    ParameterSpec(
        'keep_upright', False, 'Turn what is placed about the vertical only, as full cups need it.'
    ),
    ParameterSpec(
        'keep_on_table',
        False,
        'Leave what is placed standing on the table, beside the other object or leaning on it.',
    ),
    ParameterSpec(
        'approach_height',
        DEFAULTS.approach_height,
        'Length of the straight way from the approach pose to the target, metres.',
        minimum=0.0,
        maximum=2.0,
    ),
    ParameterSpec(
        'table_height',
        math.nan,
        'World z of the table, metres; NaN: as perception sees it.',
        minimum=-1000.0,
        maximum=1000.0,
        may_be_nan=True,
    ),
    *ROBOT_PARAMETERS,
    *FOLLOW_PARAMETERS,
    ParameterSpec(
        'publish_infeasible',
        False,
        'Publish target poses of answers that are not feasible too; a robot may follow them.',
    ),
    RERUN,
    ParameterSpec('seed', 0, 'Of everything random.', minimum=0, maximum=2**31 - 1),
)


def default_options(parameters: Parameters, seen_table_height: float | None) -> ImitationOptions:
    """Options of a request that says nothing.

    Args:
        parameters: of the node, as they are set now.
        seen_table_height: of the table that perception sees, metres; None if it sees none.
    """
    table_height = parameters.number('table_height')
    return ImitationOptions(
        time_budget_sec=parameters.number('time_budget') or None,
        keep_upright=parameters.flag('keep_upright'),
        keep_on_table=parameters.flag('keep_on_table'),
        num_proposals=parameters.integer('num_proposals'),
        num_starts=parameters.integer('num_starts'),
        max_steps=parameters.integer('max_steps'),
        approach_height=parameters.number('approach_height'),
        table_height=seen_table_height if math.isnan(table_height) else table_height,
        seed=parameters.integer('seed'),
    )
