"""When the follower imitates again: with a real node, and scenes that are given to it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor

from spatial_relations_ros.core import Pose, Scene, SceneObject, UnknownObjectError
from spatial_relations_ros.imitation import (
    ImitationAnswer,
    ImitationOptions,
    ImitationResult,
    ObjectPlacement,
)
from spatial_relations_ros.nodes.follow_parameters import FOLLOW_PARAMETERS
from spatial_relations_ros.nodes.follower import RETRY_FACTOR, STILL_SEC, Follower
from spatial_relations_ros.nodes.scene_client import SeenScene
from spatial_relations_ros.ros.diagnostics import OK, WARN
from spatial_relations_ros.ros.domains import free_domain_id
from spatial_relations_ros.ros.relations_node import RelationsNode

pytestmark = pytest.mark.ros

POINTS = np.random.default_rng(0).uniform(-0.05, 0.05, (64, 3)).astype(np.float32)
LIMIT_SEC = 20.0


def scene(relative_x: float) -> Scene:
    return Scene(
        SceneObject('plate', POINTS, Pose(np.zeros(3))),
        SceneObject('cup', POINTS, Pose(np.array([relative_x, 0.0, 0.1]))),
    )


class Watched:
    """A follower with the scenes and results that a test gives it, and what it asked for."""

    def __init__(self, context: Context) -> None:
        self.reference, self.success, self.problem = scene(0.0), True, ''
        # Of the demonstration that goes on: places that are still to come.
        self.coming: list[Scene] = []
        self.runs: list[ImitationOptions] = []
        self.node = RelationsNode(
            'watched', FOLLOW_PARAMETERS, context=context, use_global_arguments=False,
            cli_args=['--ros-args', '-p', 'follow:=[plate/cup, tray/mug]'],
        )  # fmt: skip
        self.follower = Follower(
            self.node, self._resolve, lambda _, __: ImitationOptions(), self._run
        )
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self.node)

    def _resolve(self, _: Any) -> tuple[Scene, SeenScene]:
        if self.problem:
            raise UnknownObjectError(self.problem)
        if self.coming:
            self.reference = self.coming.pop(0)
        return self.reference, SeenScene(scene(0.3))

    def _run(self, _: Scene, seen: SeenScene, options: ImitationOptions, *__: Any) -> Any:
        self.runs.append(options)
        base, relative = (
            ObjectPlacement(o.object_id, pose, pose, pose, True, 0.0, True)
            for o in seen.scene.objects
            for pose in [o.world_from_object]
        )
        answer = ImitationAnswer((base, relative), 0.1, 0.9, self.success, ())
        history = np.zeros(1, dtype=np.float32)
        return ImitationResult(self.success, 'no', (answer,), history, 1.0, 0.0, 0)

    def spin(self, sec: float) -> None:
        end_ns = self.node.get_clock().now().nanoseconds + round(1e9 * sec)
        while self.node.get_clock().now().nanoseconds < end_ns:
            self._executor.spin_once(timeout_sec=0.02)

    def spin_until(self, num_runs: int) -> None:
        end_ns = self.node.get_clock().now().nanoseconds + round(1e9 * LIMIT_SEC)
        while len(self.runs) < num_runs:
            assert self.node.get_clock().now().nanoseconds < end_ns, f'{len(self.runs)} runs'
            self._executor.spin_once(timeout_sec=0.02)


@pytest.fixture
def watched() -> Iterator[Watched]:
    context = Context()
    rclpy.init(context=context, domain_id=free_domain_id())
    watched = Watched(context)
    yield watched
    watched.follower.close()
    watched.node.destroy_node()
    rclpy.shutdown(context=context)


def test_a_change_is_imitated_from_the_last_success_and_stillness_is_not(
    watched: Watched,
) -> None:
    watched.spin_until(1)
    assert watched.runs[0].start is None
    watched.spin(0.5)  # five looks
    assert len(watched.runs) == 1
    watched.reference = scene(0.02)
    watched.spin_until(2)
    assert watched.runs[1].start is not None


def test_what_goes_on_changing_is_looked_at_again_at_once(watched: Watched) -> None:
    """Not only when the timer is due: that would cost a part of each period."""
    watched.coming = [scene(0.02 * idx) for idx in range(6)]
    watched.spin_until(1)
    assert len(watched.runs) == 6


def test_what_found_nothing_is_retried_once_after_a_second_of_stillness(
    watched: Watched,
) -> None:
    watched.success = False
    for num, relative_x in enumerate((0.0, 0.02, 0.04, 0.06), start=1):
        # While it moves each look is a new imitation in the short time.
        watched.reference = scene(relative_x)
        watched.spin_until(num)
    budgets = {options.time_budget_sec for options in watched.runs}
    assert len(budgets) == 1
    watched.spin(0.5 * STILL_SEC)
    assert len(watched.runs) == 4
    watched.spin_until(5)
    assert watched.runs[4].time_budget_sec == pytest.approx(RETRY_FACTOR * budgets.pop())
    watched.spin(1.5 * STILL_SEC)
    assert len(watched.runs) == 5


def test_a_lost_object_pauses_with_the_reason_and_the_answer_is_kept(watched: Watched) -> None:
    watched.spin_until(1)
    watched.problem = 'cup: LOST'
    watched.spin(0.5)
    state = watched.follower.state()
    assert state.level == WARN
    assert 'cup: LOST' in state.message
    watched.problem, watched.reference = '', scene(0.02)
    watched.spin_until(2)
    watched.spin(0.3)
    assert watched.follower.state().level == OK
    assert watched.runs[1].start is not None
