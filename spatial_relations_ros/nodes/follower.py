"""Lets target poses follow a demonstration while a person changes it."""

from __future__ import annotations

import dataclasses
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from spatial_relations_msgs.srv import Imitate

from spatial_relations_ros.core import Pose, Scene
from spatial_relations_ros.imitation import ImitationOptions, ImitationProgress, ImitationResult
from spatial_relations_ros.imitation.relation_change import (
    RelationChange,
    relation_change,
    turn_angle_rad,
)
from spatial_relations_ros.nodes.follow_parameters import IdPair, followed_pairs
from spatial_relations_ros.nodes.scene_client import SeenScene
from spatial_relations_ros.ros.diagnostics import OK, WARN, State
from spatial_relations_ros.ros.relations_node import RelationsNode
from spatial_relations_ros.ros.timers import steady_timer

RATE_WINDOW_SEC = 10.0
RETRY_FACTOR = 4.0
# A retry takes long: a demonstration that only slows down must not have to wait for it.
STILL_SEC = 1.0
PARAMETER = 'follow'

Resolve = Callable[[Any], tuple[Scene, SeenScene]]
MakeOptions = Callable[[Any, SeenScene], ImitationOptions]


class Run(Protocol):
    """Runs one imitation and publishes its answer."""

    def __call__(
        self,
        reference: Scene,
        seen: SeenScene,
        options: ImitationOptions,
        is_cancelled: Callable[[], bool],
        on_progress: Callable[[ImitationProgress, Scene], None],
    ) -> ImitationResult:
        """As ``ImitateNode`` does for requests."""


@dataclass(frozen=True)
class _Followed:
    """The last answer and what it was an answer to."""

    reference: Scene
    test: Scene
    result: ImitationResult
    num_tries: int
    time_sec: float


class Follower:
    """Imitates anew each time what is followed has changed, beginning with the last answer.

    The parameter ``follow`` starts and stops it. Scenes are asked of ``~/get_scene``: only those
    that are wanted come, whatever ``pairs`` and ``publish_rate`` of perception say, and where
    there is none the reason does.
    """

    def __init__(
        self, node: RelationsNode, resolve: Resolve, options: MakeOptions, run: Run
    ) -> None:
        """Starts when the parameter says so.

        Args:
            node: with the parameters of ``FOLLOW_PARAMETERS``.
            resolve: gives reference and test of a request.
            options: makes the options of a request.
            run: runs one imitation and publishes its answer.
        """
        self._node, self._resolve, self._options, self._run = node, resolve, options, run
        self._lock = threading.Lock()
        self._pairs: tuple[IdPair, IdPair] | None = None
        self._last: _Followed | None = None
        self._problem = ''
        self._updates_sec: deque[float] = deque(maxlen=1000)
        self._num_updates = 0
        # Each change of the parameters or reset begins a new era; jobs of older ones are over.
        self._era = 0
        group = MutuallyExclusiveCallbackGroup()
        self._timer = steady_timer(node, 1.0, self._tick, group=group)
        node.parameters.on_change((PARAMETER, 'follow_movable', 'follow_rate'), self._begin)
        node.diagnostics.add_state('follow', self.state)
        self._begin()

    def _begin(self) -> None:
        parameters = self._node.parameters
        self._pairs = followed_pairs(parameters.texts(PARAMETER))
        self.forget()
        self._timer.timer_period_ns = round(1e9 / parameters.number('follow_rate'))
        if self._pairs is None:
            self._timer.cancel()
        else:
            self._timer.reset()

    def forget(self) -> None:
        """Begins anew, without the last answer; what runs is cancelled."""
        with self._lock:
            self._era += 1
            self._last, self._problem = None, ''
            self._updates_sec.clear()
            self._num_updates = 0

    def close(self) -> None:
        """Ends it."""
        self._timer.cancel()
        self._era += 1

    def _tick(self) -> None:
        """Looks; while new imitations are made again at once, not when the timer is due."""
        pairs, era = self._pairs, self._era
        if pairs is None:
            return
        is_looking = True
        while is_looking and era == self._era:
            try:
                is_looking, problem = self._look(pairs, era), ''
            except Exception as error:  # the node and the following go on
                is_looking, problem = False, self._node.report_bad(PARAMETER, error)
            with self._lock:
                if era == self._era:
                    self._problem = problem

    def _look(self, pairs: tuple[IdPair, IdPair], era: int) -> bool:
        """Imitates when there is something new; gives whether it did."""
        request = Imitate.Request(
            reference_ids=list(pairs[0]),
            test_ids=list(pairs[1]),
            movable_ids=self._node.parameters.texts('follow_movable'),
        )
        reference, seen = self._resolve(request)
        last = self._last
        num_tries = 1
        if last is not None and not self._has_changed(last, reference, seen.scene):
            is_still = time.monotonic() - last.time_sec >= STILL_SEC
            if last.result.success or last.num_tries > 1 or not is_still:
                return False
            num_tries = last.num_tries + 1
        options = self._options(request, seen)
        budget_sec = self._node.parameters.number('follow_time_budget')
        options = dataclasses.replace(
            options,
            time_budget_sec=budget_sec * (1.0 if num_tries == 1 else RETRY_FACTOR),
            start=None if last is None else start_of(last.result, seen.scene, options),
        )
        result = self._run(reference, seen, options, lambda: era != self._era, lambda *_: None)
        with self._lock:
            if era != self._era:
                return False
            now_sec = time.monotonic()
            self._last = _Followed(reference, seen.scene, result, num_tries, now_sec)
            self._num_updates += 1
            self._updates_sec.append(now_sec)
            return True

    def _has_changed(self, last: _Followed, reference: Scene, test: Scene) -> bool:
        parameters = self._node.parameters
        metres, angle_rad = (
            parameters.number('follow_distance'),
            parameters.number('follow_angle'),
        )
        base_change = pose_change(last.test.base.world_from_object, test.base.world_from_object)
        return relation_change(last.reference, reference).exceeds(
            metres, angle_rad
        ) or base_change.exceeds(metres, angle_rad)

    def state(self) -> State:
        """For diagnostics."""
        pairs = self._pairs
        if pairs is None:
            return State(OK, 'off')
        now_sec = time.monotonic()
        with self._lock:
            last, problem = self._last, self._problem
            recent = [t for t in self._updates_sec if now_sec - t < RATE_WINDOW_SEC]
            values: dict[str, object] = {
                'updates': self._num_updates,
                'rate_hz': f'{len(recent) / RATE_WINDOW_SEC:.1f}',
            }
            if self._updates_sec:
                values['last_update_age_sec'] = f'{now_sec - self._updates_sec[-1]:.1f}'
        if last is not None:
            values |= {
                'distance': f'{last.result.answers[0].distance:.3f}',
                'duration_ms': f'{1e3 * last.result.duration_sec:.0f}',
            }
        words = '{} with {}'.format(*('/'.join(pair) for pair in pairs))
        if problem:
            return State(WARN, f'following {words}: {problem}', values)
        if last is not None and not last.result.success:
            return State(WARN, f'following {words}: {last.result.message}', values)
        return State(OK, f'following {words}', values)


def pose_change(before: Pose, after: Pose) -> RelationChange:
    """How far an object moved and turned in the world."""
    shift = after.translation - before.translation
    return RelationChange(float((shift @ shift) ** 0.5), turn_angle_rad(before, after))


def start_of(
    result: ImitationResult, test: Scene, options: ImitationOptions
) -> tuple[Pose, Pose] | None:
    """The last answer as poses of the objects where they are now; None when it was none.

    Args:
        result: of the last imitation.
        test: the objects where they stand now.
        options: say which of them may move. A base that may not has its relative brought along.
    """
    if not result.success:
        return None
    base, relative = (placement.target for placement in result.answers[0].placements)
    if 'base' in options.movable:
        return base, relative
    now = test.base.world_from_object
    return now, now @ base.inverse() @ relative
