"""What a cloud says about the pose of an object whose surface is known."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError, Pose
from spatial_relations_ros.perception.support import count_support
from spatial_relations_ros.perception.track_state import Evidence, Observation
from spatial_relations_ros.perception.view import View

# Points deeper below the table stand on something else, such as the floor.
MAX_SUNK_DEPTH = 0.2


@dataclass(frozen=True)
class SupportConfig:
    """How much of an object the cloud must confirm.

    Attributes:
        min_support: an object that the cloud confirms less is contradicted; 0 believes every
            tracker.
        hysteresis: how much more than ``min_support`` it takes to gain a belief than to keep it.
        tolerance: depth difference that is still the same surface, metres.
        rival_margin: how much more support the model of a rival needs at an object's place to
            prove that their ids are swapped.
    """

    min_support: float = 0.4
    hysteresis: float = 0.2
    tolerance: float = 0.015
    rival_margin: float = 0.1

    def __post_init__(self) -> None:
        if not 0 <= self.min_support <= 1:
            raise ConfigError(f'min_support is {self.min_support}, expected 0 to 1')
        if not (0 <= self.hysteresis <= 1 and 0 <= self.rival_margin <= 1):
            raise ConfigError(f'hysteresis and margin are 0 to 1, got {self}')
        if not 0 < self.tolerance < math.inf:
            raise ConfigError(f'the tolerance must be positive, got {self}')

    @property
    def good_support(self) -> float:
        """Support from which on a new pose is believed."""
        return min(1.0, self.min_support + self.hysteresis)


def support_at(surface: NDArray[np.floating], pose: Pose, view: View, tolerance: float) -> float:
    """Share of the visible surface that the cloud confirms.

    Args:
        surface: (N, 3) spread over it, object frame, metres.
        pose: ``world_from_object``.
        view: the cloud.
        tolerance: depth difference that is still the same surface, metres.

    Returns:
        0 to 1; NaN when too little of it is in view, or the cloud is not a camera's.
    """
    if view.camera is None:
        return math.nan
    world_points = pose.apply(surface)
    is_sunk = None
    if view.table is not None:
        heights = view.table.heights(world_points)
        is_sunk = (heights < -tolerance) & (heights > -MAX_SUNK_DEPTH)
    return count_support(
        view.to_cloud(world_points),
        view.cloud,
        view.camera,
        tolerance=tolerance,
        is_sunk=is_sunk,
    ).support


def judge_support(support: float, view: View, config: SupportConfig) -> Observation:
    """The evidence of a support.

    Args:
        support: 0 to 1, or NaN.
        view: where it was measured.
        config: how much is needed.
    """
    if view.camera is None or config.min_support == 0.0:
        return Observation(Evidence.CONFIRMED, support)
    if math.isnan(support):
        return Observation(Evidence.NONE, support, 'its place is hidden or out of view')
    if support < config.min_support:
        reason = f'tracked pose has no support in the cloud ({100 * support:.0f} %)'
        return Observation(Evidence.CONTRADICTED, support, reason)
    if support < config.good_support:
        reason = (
            f'tracked pose has little support in the cloud ({100 * support:.0f} %, '
            f'{100 * config.good_support:.0f} % are needed for a new one)'
        )
        return Observation(Evidence.WEAK, support, reason)
    return Observation(Evidence.CONFIRMED, support)


def judge_rival(
    seen: Observation, rival_id: str, rival_support: float, config: SupportConfig
) -> Observation:
    """The evidence when another object's model was tried at the same pose.

    Args:
        seen: the evidence of the object's own model.
        rival_id: the other object, with which it may have been swapped.
        rival_support: support of that one's model at this object's pose.
        config: by how much it must fit better.
    """
    own = 0.0 if math.isnan(seen.support) else seen.support
    if not rival_support > own + config.rival_margin:
        return seen
    reason = (
        f'the cloud fits {rival_id} better there ({100 * rival_support:.0f} % against '
        f'{100 * own:.0f} %): the tracker has swapped their ids'
    )
    return Observation(Evidence.CONTRADICTED, seen.support, reason)
