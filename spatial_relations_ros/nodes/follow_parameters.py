"""Parameters about following a demonstration while it changes."""

from __future__ import annotations

from collections.abc import Sequence

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.nodes.perception_parameters import ordered_pairs
from spatial_relations_ros.ros.parameters import ParameterSpec

IdPair = tuple[str, str]


def followed_pairs(entries: Sequence[str]) -> tuple[IdPair, IdPair] | None:
    """The demonstration and the test objects of ``follow``; None when nothing is followed.

    Raises:
        ConfigError: for anything else than two pairs.
    """
    if not entries:
        return None
    if len(entries) != 2:
        raise ConfigError(
            f'follow has {len(entries)} entries; expected two, the demonstration and the test '
            'objects, "base/relative" each, or none'
        )
    reference, test = ordered_pairs(entries, name='follow')
    return reference, test


FOLLOW_PARAMETERS = (
    ParameterSpec(
        'follow',
        [],
        'Target poses follow a demonstration while it changes: two entries "base/relative", the '
        'demonstration and the test objects; empty: they do not.',
        check=followed_pairs,
    ),
    ParameterSpec(
        'follow_movable',
        [],
        'Which of the test objects may move then; empty: the relative one only.',
    ),
    ParameterSpec(
        'follow_rate',
        10.0,
        'How often it is looked whether what is followed has changed, Hz; after each imitation at '
        'once.',
        minimum=0.1,
        maximum=30.0,
    ),
    ParameterSpec(
        'follow_distance',
        0.01,
        'By how much an object must have moved before targets are found anew, metres.',
        minimum=0.0,
        maximum=1.0,
    ),
    ParameterSpec(
        'follow_angle',
        0.1,
        'By how much an object must have turned before targets are found anew, radians.',
        minimum=0.0,
        maximum=3.14,
    ),
    ParameterSpec(
        'follow_time_budget',
        0.2,
        'Seconds that new targets may take while something is followed; four times as many once '
        'when none were found and the demonstration has stood still for a second.',
        minimum=0.05,
        maximum=60.0,
    ),
)
