"""What can be asked of an imitation."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from spatial_relations_ros.core import ConfigError, Pose
from spatial_relations_ros.imitation.manipulation import ArmReach, Obstacle

ROLES = ('base', 'relative')


@dataclass(frozen=True)
class ImitationOptions:
    """Settings of one imitation.

    Attributes:
        movable: which of ``base`` and ``relative`` may move.
        num_answers: how many distinct answers to return at most; all but the first are successes.
        time_budget_sec: after 90 % of it only the best answer is finished; None or 0 for no
            limit.
        keep_heading: also keep the horizontal direction of the demonstration.
        keep_upright: leave what is moved in the orientation in which it stands, but for its
            heading.
        keep_on_table: leave what is moved standing on the table, beside the other object or
            leaning on it.
        start: world_from_object of base and relative to begin with, such as the last answer to a
            demonstration that moves. What is found near it and is clearly alike is the answer;
            only else placements are proposed.
        propose: start from placements proposed from the shapes, not only from the current one.
        num_proposals: how many of them are compared with the demonstration.
        num_starts: how many of the nearest are refined by gradient descent. With one start and
            ``propose`` off this is the paper's optimisation.
        max_steps: Adam steps of each refinement.
        learning_rate: of Adam, as a share of the scene's extent (translation) and in radians
            (rotation) a step.
        learning_rate_spread: every start but the first descends at a rate drawn between the rate
            divided and multiplied by this; 1 for the same rate.
        soft_refinement: refine through soft images whose width shrinks, rather than by the
            metric's own gradient; for comparison.
        physics_weight: weight of penetration and contact against the metric; 0 for the metric
            alone.
        layout_weight: weight of a horizontal layout or a lean other than the demonstration's,
            which the metric tells apart least; 0 leaves them out.
        table_height: height of the table in the world frame, metres; None takes the lowest
            point of the test objects where they stand now.
        approach_height: length of the straight way from the approach pose to the target, metres;
            from above where nothing stands in the way.
        obstacles: other things in the scene, without the test objects.
        arm: what the arms reach; None leaves reach unchecked.
        grasps: object id -> object_from_gripper, where the gripper holds it.
        seed: for everything random.

    Raises:
        ConfigError: for values that cannot be used.
    """

    movable: tuple[str, ...] = ('relative',)
    num_answers: int = 1
    time_budget_sec: float | None = None
    keep_heading: bool = False
    keep_upright: bool = False
    keep_on_table: bool = False
    start: tuple[Pose, Pose] | None = None
    propose: bool = True
    num_proposals: int = 96
    num_starts: int = 3
    max_steps: int = 8
    learning_rate: float = 0.015
    learning_rate_spread: float = 2.0
    soft_refinement: bool = False
    physics_weight: float = 1.0
    layout_weight: float = 0.25
    table_height: float | None = None
    approach_height: float = 0.1
    obstacles: tuple[Obstacle, ...] = ()
    arm: ArmReach | None = None
    grasps: Mapping[str, Pose] = field(default_factory=dict)
    seed: int = 0

    def __post_init__(self) -> None:
        if not self.movable or any(role not in ROLES for role in self.movable):
            raise ConfigError(f'movable is {self.movable}; expected one or both of {ROLES}')
        if self.num_answers < 1 or self.num_starts < 1 or self.max_steps < 0:
            raise ConfigError(
                f'num_answers {self.num_answers}, num_starts {self.num_starts} and max_steps '
                f'{self.max_steps} must be at least 1, 1 and 0'
            )
        if self.num_proposals < 1:
            raise ConfigError(f'num_proposals is {self.num_proposals}; expected 1 or more')
        budget = self.time_budget_sec
        if budget is not None and not (math.isfinite(budget) and budget >= 0.0):
            raise ConfigError(f'time_budget_sec is {budget}; expected 0 or more seconds')
        if self.table_height is not None and not math.isfinite(self.table_height):
            raise ConfigError(f'table_height is {self.table_height}; expected metres')
        if not 0.0 <= self.approach_height < math.inf:
            raise ConfigError(f'approach_height is {self.approach_height}; expected metres')
        if not self.learning_rate > 0.0:
            raise ConfigError(f'learning_rate is {self.learning_rate}; it must be positive')
        if not 1.0 <= self.learning_rate_spread < math.inf:
            raise ConfigError(
                f'learning_rate_spread is {self.learning_rate_spread}; expected 1 or more'
            )
        if not (self.physics_weight >= 0.0 and self.layout_weight >= 0.0):
            raise ConfigError('physics_weight and layout_weight must not be negative')

    @staticmethod
    def paper() -> ImitationOptions:
        """The optimisation of Jund et al. 2018: both objects, one start, the metric alone."""
        return ImitationOptions(
            movable=ROLES, num_starts=1, propose=False, max_steps=600, learning_rate=0.1,
            physics_weight=0.0, layout_weight=0.0,
        )  # fmt: skip
