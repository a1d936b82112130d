"""How soon a cancelled goal answers over DDS.

Run as ``python -m spatial_relations_ros.nodes.cancel_timing``. It starts ``imitate_node`` in a
graph of its own, sends the same goal again and again, and cancels each at a random moment of the
time that a whole request takes.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.task import Future
from spatial_relations_msgs.action import ImitateRelation

from spatial_relations_ros.core import Pose, Scene, SceneObject, atomic_write, share_path
from spatial_relations_ros.datasets.object_files import ObjectLibrary
from spatial_relations_ros.ros.conversions import scene_to_msg
from spatial_relations_ros.ros.domains import free_domain_id
from spatial_relations_ros.ros.processes import NodeProcesses, local_graph
from spatial_relations_ros.ros.running import spun
from spatial_relations_ros.ros.waiting import NoAnswerError, sent_by, wait_for, wait_until

START_SEC, ANSWER_SEC = 300.0, 120.0
NUM_CANCELS, NUM_WHOLE = 30, 6


@dataclass
class Timings:
    """What was measured, seconds.

    Attributes:
        whole: of requests that were let go on to their end.
        cancels: from sending the cancellation to the arrival of the result.
        feedback: between one feedback and the next.
        num_late: goals that had ended by themselves before their cancellation came.
    """

    whole: list[float] = field(default_factory=list)
    cancels: list[float] = field(default_factory=list)
    feedback: list[float] = field(default_factory=list)
    num_late: int = 0

    def summary(self) -> dict[str, Any]:
        """Counts and percentiles, milliseconds."""
        return {
            'late': self.num_late,
            **{
                name: {
                    'count': len(values),
                    **{f'p{q}_ms': 1e3 * float(np.percentile(values, q)) for q in (50, 90, 99)},
                    'max_ms': 1e3 * max(values),
                }
                for name, values in vars(self).items()
                if isinstance(values, list) and values
            },
        }


class Client:
    """Sends goals and cancels them."""

    def __init__(self, node: Node, executor: Executor, goal: ImitateRelation.Goal) -> None:
        self._executor = executor
        self._action = ActionClient(node, ImitateRelation, 'imitate_relation')
        self._goal = goal
        self.timings = Timings()

    def wait(self, processes: NodeProcesses) -> None:
        """Waits for the server.

        Raises:
            NoAnswerError: when it does not come.
        """

        def is_ready() -> bool:
            processes.check()
            return bool(self._action.server_is_ready())

        if not wait_until(is_ready, START_SEC):
            raise NoAnswerError(f'imitate_relation did not come within {START_SEC:g} s')

    def run(self, cancel_after_sec: float | None) -> None:
        """One goal, cancelled after a time or let go on to its end."""
        stamps: list[float] = []
        start = time.perf_counter()

        def send() -> Future:
            return self._action.send_goal_async(
                self._goal, feedback_callback=lambda _: stamps.append(time.perf_counter())
            )

        handle = wait_for(sent_by(self._executor, send, ANSWER_SEC), ANSWER_SEC)
        result = sent_by(self._executor, handle.get_result_async, ANSWER_SEC)
        if cancel_after_sec is None:
            wait_for(result, ANSWER_SEC)
            self.timings.whole.append(time.perf_counter() - start)
            self.timings.feedback += np.diff(stamps).tolist()
            return
        with contextlib.suppress(NoAnswerError):
            wait_for(result, max(cancel_after_sec, 1e-3))
        cancelled = time.perf_counter()
        sent_by(self._executor, handle.cancel_goal_async, ANSWER_SEC)
        outcome = wait_for(result, ANSWER_SEC)
        if outcome.status == GoalStatus.STATUS_CANCELED:
            self.timings.cancels.append(time.perf_counter() - cancelled)
        else:
            self.timings.num_late += 1


def demonstration() -> ImitateRelation.Goal:
    """The shipped tray and mug like its plate and cup, as clouds that messages hold."""
    library = ObjectLibrary(share_path('bags', 'objects'))

    def item(name: str, place: tuple[float, float], height: float) -> SceneObject:
        _, points = library[name]
        lift = height - float(points[:, 2].min())
        return SceneObject(name, points, Pose(np.array([*place, lift])))

    plate = library['plate'][1]
    reference = Scene(
        item('plate', (0.0, 0.0), 0.0), item('cup', (0.0, 0.0), float(np.ptp(plate[:, 2])))
    )
    test = Scene(item('tray', (0.5, 0.0), 0.0), item('mug', (0.5, 0.4), 0.0))
    return ImitateRelation.Goal(
        reference_scene=[scene_to_msg(reference)], test_scene=[scene_to_msg(test)]
    )


def measure(num_cancels: int, num_whole: int, seed: int, folder: Path) -> Timings:
    """Starts the node, makes so many whole requests, then cancels so many.

    Raises:
        NoAnswerError: when the node does not come or does not answer.
    """
    domain_id = free_domain_id()
    environment = local_graph(domain_id, folder)
    os.environ.update(environment)
    rng = np.random.default_rng(seed)
    with NodeProcesses(environment, folder) as processes:
        processes.start('imitate_node', parameters={'standalone': False, 'time_budget': 0.0})
        with spun(lambda: Node('cancel_timing'), domain_id) as node:
            client = Client(node, node.executor, demonstration())
            client.wait(processes)
            client.run(None)  # loads the weights and prepares the shapes
            client.timings = Timings()
            for _ in range(num_whole):
                client.run(None)
            longest = float(np.median(client.timings.whole))
            while len(client.timings.cancels) < num_cancels:
                client.run(float(rng.uniform(0.0, longest)))
            return client.timings


def _count(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f'{text} asked for; expected 1 or more')
    return number


def main(arguments: Sequence[str] | None = None) -> int:
    """Prints, and writes with ``--json``, what was measured."""
    parser = argparse.ArgumentParser(prog='cancel_timing', description=__doc__)
    parser.add_argument('--cancels', type=_count, default=NUM_CANCELS, help='so many goals')
    parser.add_argument('--whole', type=_count, default=NUM_WHOLE, help='goals let go on before')
    parser.add_argument('--seed', type=int, default=0, help='of the moments of cancelling')
    parser.add_argument('--json', type=Path, help='file for the results')
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory(prefix='cancel_timing_') as folder:
        timings = measure(options.cancels, options.whole, options.seed, Path(folder))
    text = json.dumps(timings.summary(), indent=2) + '\n'
    sys.stdout.write(text)
    if options.json is not None:
        with atomic_write(options.json) as temporary:
            temporary.write_text(text)
    return 0


if __name__ == '__main__':
    sys.exit(main())
