"""The demonstration: python -m spatial_relations_ros.nodes.demo.

Starts the three nodes as processes, replays the recorded bag to them over DDS, asks for the
planned imitations and writes what comes back. Exit code 0 only when target poses were received for
all of them and each distance fell.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from spatial_relations_ros.core import SpatialRelationsError
from spatial_relations_ros.core.interrupts import interrupt_on_signals
from spatial_relations_ros.evaluation.bag_reader import BagReader
from spatial_relations_ros.learning import load_metric
from spatial_relations_ros.nodes.bag_player import BagPlayer
from spatial_relations_ros.nodes.demo_client import DemoClient
from spatial_relations_ros.nodes.demo_plan import DemoPlan, PlannedImitation, read_demo_plan
from spatial_relations_ros.nodes.demo_report import (
    DemoOutcome,
    print_outcome,
    write_pictures,
    write_result,
)
from spatial_relations_ros.nodes.scene_requests import with_meshes
from spatial_relations_ros.pipeline import LibraryModels
from spatial_relations_ros.ros.domains import free_domain_id
from spatial_relations_ros.ros.processes import NodeProcesses, local_graph
from spatial_relations_ros.ros.running import spun
from spatial_relations_ros.ros.waiting import NoAnswerError, wait_until

# Generous: a first start on a busy machine imports for most of a minute.
START_TIMEOUT_SEC = 300.0
# Enough for a slow or busy machine to refine; answers come as soon as they are found.
IMITATION_BUDGET_SEC = 60.0
ANSWER_TIMEOUT_SEC = IMITATION_BUDGET_SEC + 120.0
TOPIC_TIMEOUT_SEC = 10.0
# How long the replay waits for the scenes of one cloud before it goes on without them.
CLOUD_TIMEOUT_SEC = 2.0


class Demo:
    """One run of the demonstration."""

    def __init__(self, plan: DemoPlan, out: Path, weights: str, console: Console) -> None:
        self._plan, self._out, self._weights, self._console = plan, out, weights, console
        self._models = LibraryModels(plan.models_path)
        self._start_sec = time.monotonic()

    def run(self) -> bool:
        """Runs everything; True when each imitation is what was asked for.

        Raises:
            SpatialRelationsError: when a node, the bag or an answer is missing.
        """
        metric = load_metric(self._weights or None)
        with BagReader(self._plan.bag):
            pass  # a bag that cannot be read is known before anything starts
        log_folder = self._out / 'log'
        environment = local_graph(free_domain_id(), log_folder)
        os.environ.update(environment)
        with NodeProcesses(environment, log_folder) as processes:
            self._start_nodes(processes)
            with spun(DemoClient) as client:
                self._say('waiting for the three nodes to come up')
                self._wait_for_nodes(processes, client)
                self._replay(processes, client)
                outcomes = [self._imitate(client, planned) for planned in self._plan.imitations]
                seen = {'/'.join(pair): count for pair, count in client.scene_counts.items()}
        write_result(self._out / 'result.json', outcomes, seen=seen, model_hash=metric.model_hash)
        for outcome in outcomes:
            print_outcome(self._console, outcome)
        for idx, outcome in enumerate(outcomes):
            folder = self._out if idx == 0 else self._out / outcome.plan.relation
            num_pictures = write_pictures(folder, outcome, metric)
            self._say(f'{num_pictures} pictures in {folder}')
        return all(not outcome.problem for outcome in outcomes)

    def _say(self, text: str) -> None:
        elapsed_sec = time.monotonic() - self._start_sec
        self._console.print(f'[dim]{elapsed_sec:6.1f} s[/dim]  ', end='')
        self._console.print(text, markup=False, highlight=False, soft_wrap=True)

    def _start_nodes(self, processes: NodeProcesses) -> None:
        self._say('starting perception_node, metric_node and imitate_node')
        models_path = str(self._plan.models_path.resolve())
        pairs = [
            '/'.join(pair)
            for planned in self._plan.imitations
            for pair in (planned.reference_ids, planned.test_ids)
        ]
        processes.start(
            'perception_node',
            parameters={
                'pairs': pairs,
                'publish_rate': 100.0,
                'models_path': models_path,
                'world_frame': self._plan.world_frame,
                'reliable_points': True,
                # The requests come after the replay, one after the other.
                'max_age': 600.0,
            },
            remappings={
                '~/points': self._plan.points_topic,
                '~/tracked_objects': self._plan.tracked_objects_topic,
            },
        )
        memory = str((self._out / 'relations.sqlite3').resolve())
        weights = {'weights': self._weights} if self._weights else {}
        frame = {'world_frame': self._plan.world_frame}
        processes.start('metric_node', parameters={'memory_path': memory, **frame, **weights})
        processes.start(
            'imitate_node',
            parameters={'models_path': models_path, 'standalone': 'false', **frame, **weights},
        )

    def _wait_for_nodes(self, processes: NodeProcesses, client: DemoClient) -> None:
        def are_up() -> bool:
            processes.check()
            return not client.missing_services()

        if not wait_until(are_up, START_TIMEOUT_SEC):
            missing = ', '.join(client.missing_services())
            raise NoAnswerError(f'after {START_TIMEOUT_SEC:g} s there is no service {missing}')

    def _replay(self, processes: NodeProcesses, client: DemoClient) -> None:
        player = BagPlayer(client, self._plan.bag)
        topics = [self._plan.points_topic, self._plan.tracked_objects_topic]
        player.wait_for_subscribers(topics, START_TIMEOUT_SEC)
        self._say(f'replaying {self._plan.bag.name}: {player.duration_sec:.1f} s over DDS')

        def wait_for_perception(cloud_ns: int) -> None:
            client.wait_for_scene_of(cloud_ns, CLOUD_TIMEOUT_SEC)

        num_messages = player.play(wait_for_perception)
        pairs = {
            pair
            for planned in self._plan.imitations
            for pair in (planned.reference_ids, planned.test_ids)
        }

        def are_seen() -> bool:
            processes.check()
            return all(client.has_scene(pair) for pair in pairs)

        if not wait_until(are_seen, TOPIC_TIMEOUT_SEC):
            unseen = [pair for pair in sorted(pairs) if not client.has_scene(pair)]
            reasons = '; '.join(self._why_unseen(client, pair) for pair in unseen)
            raise NoAnswerError(f'perception published no scene of: {reasons}')
        self._say(
            f'{num_messages} messages played, {sum(client.scene_counts.values())} scenes received'
        )

    @staticmethod
    def _why_unseen(client: DemoClient, pair: tuple[str, str]) -> str:
        try:
            client.scene(pair, TOPIC_TIMEOUT_SEC)
        except SpatialRelationsError as error:
            return str(error)
        return f'{"/".join(pair)}: seen, but not published'

    def _imitate(self, client: DemoClient, planned: PlannedImitation) -> DemoOutcome:
        reference, test = (
            with_meshes(client.scene(pair, TOPIC_TIMEOUT_SEC), self._models)
            for pair in (planned.reference_ids, planned.test_ids)
        )
        self._say(
            f'calling /imitate: {"/".join(planned.test_ids)} shall imitate '
            f'{"/".join(planned.reference_ids)} ({planned.relation})'
        )
        response = client.imitate(
            planned.reference_ids,
            planned.test_ids,
            ANSWER_TIMEOUT_SEC,
            time_budget_sec=IMITATION_BUDGET_SEC,
        )
        target_poses = None
        if response.success:
            target_poses = client.target_poses(TOPIC_TIMEOUT_SEC)
        return DemoOutcome(planned, reference, test, response, target_poses)


def _clear(out: Path) -> None:
    """Removes what an earlier run left, and nothing else."""
    out.mkdir(parents=True, exist_ok=True)
    for path in (*out.glob('**/*.png'), out / 'result.json', out / 'relations.sqlite3'):
        path.unlink(missing_ok=True)
    shutil.rmtree(out / 'log', ignore_errors=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the demonstration; returns the exit code."""
    parser = argparse.ArgumentParser(description='Replays the recorded bag and imitates.')
    parser.add_argument('--bags', type=Path, default=Path('bags'), help='folder of demo.yaml')
    parser.add_argument('--out', type=Path, default=Path('out/demo'), help='where results go')
    parser.add_argument('--weights', default='', help='weights file; those shipped by default')
    args = parser.parse_args(arguments)
    # Ended from outside it still ends its nodes.
    interrupt_on_signals()
    console = Console()
    try:
        plan = read_demo_plan(args.bags / 'demo.yaml')
        _clear(args.out)
        is_good = Demo(plan, args.out, args.weights, console).run()
    except SpatialRelationsError as error:
        console.print('[red]The demonstration failed:[/red]', end=' ')
        console.print(str(error), markup=False, highlight=False, soft_wrap=True)
        if (args.out / 'log').is_dir():
            console.print(f'What the nodes printed is in {args.out / "log"}')
        return 1
    except KeyboardInterrupt:
        console.print('stopped')
        return 130
    print_end = 'Done' if is_good else 'Done, with problems'
    console.print(f'{print_end}: {args.out / "result.json"}')
    return 0 if is_good else 1


if __name__ == '__main__':
    sys.exit(main())
