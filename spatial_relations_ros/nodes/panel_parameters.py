"""Parameters of panel_node."""

from __future__ import annotations

from spatial_relations_ros.nodes.perception_parameters import MODELS_PATH
from spatial_relations_ros.nodes.scene_client import SCENE_PARAMETERS
from spatial_relations_ros.ros.parameters import ParameterSpec

PANEL_PARAMETERS = (
    ParameterSpec(
        'host',
        '127.0.0.1',
        'Address to listen on; 0.0.0.0 lets everybody in the network use the robot.',
        is_fixed=True,
    ),
    ParameterSpec(
        'port', 8765, 'Port to listen on; 0: a free one.', minimum=0, maximum=65535, is_fixed=True
    ),
    ParameterSpec(
        'allowed_hosts',
        [],
        'Names of this machine under which browsers may open the page, besides localhost.',
        is_fixed=True,
    ),
    ParameterSpec(
        'rate',
        2.0,
        'How often objects are shown anew while somebody looks, Hz.',
        minimum=0.1,
        maximum=10.0,
        is_fixed=True,
    ),
    ParameterSpec(
        'camera_frame',
        '',
        'Frame of /tf from whose side objects are seen at first; empty: from the front left.',
        is_fixed=True,
    ),
    ParameterSpec(
        'imitate_relation',
        'imitate_relation',
        'Name of the action of the imitate node; relative to the namespace.',
        is_fixed=True,
    ),
    ParameterSpec(
        'answer_timeout',
        120.0,
        'Longest wait for an imitation, seconds.',
        minimum=1.0,
        maximum=3600.0,
    ),
    ParameterSpec(
        'metric',
        'metric_node',
        'Name of the metric node, which keeps remembered relations; relative to the namespace.',
        is_fixed=True,
    ),
    *SCENE_PARAMETERS,
    MODELS_PATH,
)
