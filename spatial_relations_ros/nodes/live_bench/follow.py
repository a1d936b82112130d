"""How fast target poses follow: python -m spatial_relations_ros.nodes.live_bench.follow.

Records the moving demonstration (or takes a bag of it), plays it in real time to perception_node
and imitate_node with ``follow`` set, and tells when new targets came.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseArray
from numpy.typing import NDArray
from rclpy.node import Node
from rich.console import Console
from spatial_relations_msgs.msg import Imitation

from spatial_relations_ros.core import SpatialRelationsError, atomic_write
from spatial_relations_ros.evaluation.demo_scenario import IMITATIONS
from spatial_relations_ros.evaluation.moving_scenario import BEGIN, END
from spatial_relations_ros.evaluation.record_demo_bag import (
    POINTS_TOPIC,
    TRACKS_TOPIC,
    RecordingOptions,
    record_demo_bag,
)
from spatial_relations_ros.nodes.bag_player import BagPlayer
from spatial_relations_ros.perception.messages import stamp_ns
from spatial_relations_ros.ros.domains import free_domain_id
from spatial_relations_ros.ros.processes import NodeProcesses, local_graph
from spatial_relations_ros.ros.qos import ANSWERS
from spatial_relations_ros.ros.running import spun
from spatial_relations_ros.ros.waiting import NoAnswerError, wait_until

START_SEC = 150.0
SETTLE_SEC = 10.0
STILL_SEC = 2.0
# The last update of what moved may be of a cloud a little later.
MIN_RATE = 2.0


@dataclass(frozen=True)
class Update:
    """One imitation that was published.

    Attributes:
        time_sec: when it came, on this process's steady clock.
        stamp_ns: of the cloud that it is of.
        distance: of the answer.
        feasible: whether it is.
    """

    time_sec: float
    stamp_ns: int
    distance: float
    feasible: bool


class FollowListener(Node):
    """Notes when answers and target poses come."""

    def __init__(self) -> None:
        super().__init__('follow_listener')
        self.updates: list[Update] = []
        self.targets: list[PoseArray] = []
        self.create_subscription(Imitation, 'imitate_node/imitation', self._on_answer, ANSWERS)
        self.create_subscription(PoseArray, 'target_poses', self.targets.append, ANSWERS)

    def _on_answer(self, message: Imitation) -> None:
        cloud_ns = stamp_ns(message.targets[0].current.header.stamp)
        self.updates.append(
            Update(time.monotonic(), cloud_ns, float(message.distance), bool(message.feasible))
        )


def follow_nodes(processes: NodeProcesses, models: Path) -> None:
    """Starts perception and imitation that follow the first demonstration of the bag."""
    imitation = IMITATIONS[0]
    processes.start(
        'perception_node',
        parameters={'models_path': str(models), 'reliable_points': True},
        remappings={'~/points': POINTS_TOPIC, '~/tracked_objects': TRACKS_TOPIC},
    )
    pairs = ['/'.join(imitation.reference_ids), '/'.join(imitation.test_ids)]
    processes.start(
        'imitate_node',
        parameters={'models_path': str(models), 'standalone': 'false', 'follow': pairs},
    )


def measure_following(bag: Path, models: Path, folder: Path, domain_id: int) -> dict[str, Any]:
    """Plays the bag twice, the first time to warm up, and tells what came the second time.

    Raises:
        SpatialRelationsError: when a node does not start or no targets come.
    """
    with NodeProcesses(local_graph(domain_id, folder / 'log'), folder / 'log') as processes:
        follow_nodes(processes, models)
        with spun(FollowListener, domain_id) as listener:
            player = BagPlayer(listener, bag)
            player.wait_for_subscribers([POINTS_TOPIC, TRACKS_TOPIC], START_SEC)
            sent: dict[int, float] = {}
            for _ in range(2):
                begin_sec = time.monotonic()
                if not wait_until(lambda: _is_still(listener, begin_sec), START_SEC):  # noqa: B023
                    raise NoAnswerError('imitate_node does not come to rest')
                listener.updates.clear()
                listener.targets.clear()
                sent.clear()
                player.play(lambda cloud_ns: sent.update({cloud_ns: time.monotonic()}))
            begin_sec = time.monotonic()
            wait_until(lambda: _is_still(listener, begin_sec), SETTLE_SEC)
            if not listener.updates:
                raise NoAnswerError('no imitation came while the bag was played')
            return _summary(listener, sent, player.duration_sec)


def _is_still(listener: FollowListener, begin_sec: float) -> bool:
    """Whether nothing new has come for two seconds."""
    last_sec = listener.updates[-1].time_sec if listener.updates else 0.0
    return time.monotonic() - max(begin_sec, last_sec) > STILL_SEC


def _summary(
    listener: FollowListener, sent: dict[int, float], duration_sec: float
) -> dict[str, Any]:
    """What came while the cup moved, by the stamps of the clouds."""
    begin_ns = min(sent)
    first_ns, last_ns = (begin_ns + round(1e9 * share * duration_sec) for share in (BEGIN, END))
    moving = [u for u in listener.updates if first_ns < u.stamp_ns <= last_ns + 1e9 / MIN_RATE]
    gaps = np.diff([update.time_sec for update in moving])
    delays = [u.time_sec - sent[u.stamp_ns] for u in moving if u.stamp_ns in sent]
    last = listener.updates[-1]
    return {
        'updates': len(listener.updates),
        'updates_while_moving': len(moving),
        'rate_while_moving_hz': float(1.0 / gaps.mean()) if len(gaps) else float('nan'),
        'gap_sec': _spread(gaps),
        'delay_sec': _spread(delays),
        'feasible_while_moving': sum(update.feasible for update in moving),
        'published_targets': len(listener.targets),
        'last_distance': last.distance,
        'last_feasible': last.feasible,
        'history': [
            [1e-9 * (u.stamp_ns - begin_ns), u.time_sec - sent[begin_ns], u.distance, u.feasible]
            for u in listener.updates
        ],
    }


def _spread(values: Sequence[float] | NDArray[np.float64]) -> dict[str, float]:
    if not len(values):
        return {}
    return {'median': float(np.median(values)), 'max': float(np.max(values))}


def main(arguments: Sequence[str] | None = None) -> int:
    """Measures; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--duration', type=float, default=12.0, help='of the recording, seconds')
    parser.add_argument('--cloud-rate', type=float, default=10.0, help='clouds a second')
    parser.add_argument('--json', type=Path)
    args = parser.parse_args(arguments)
    console = Console(highlight=False)
    domain_id = free_domain_id()
    try:
        with tempfile.TemporaryDirectory(prefix='relations_follow_') as name:
            folder = Path(name)
            os.environ.update(local_graph(domain_id, folder / 'log'))
            options = RecordingOptions(
                duration_sec=args.duration, cloud_rate=args.cloud_rate, is_moving=True
            )
            bag = record_demo_bag(folder, options)
            result = measure_following(bag, folder / 'objects', folder, domain_id)
    except SpatialRelationsError as error:
        console.print(f'failed: {error}', soft_wrap=True, markup=False)
        return 1
    for key, value in result.items():
        if key != 'history':
            console.print(f'{key}: {value}')
    if args.json is not None:
        with atomic_write(args.json) as temporary:
            temporary.write_text(json.dumps(result, indent=1) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
