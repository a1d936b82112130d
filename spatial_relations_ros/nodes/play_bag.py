"""play_bag: publishes a bag into the graph, as ``relations replay --publish`` starts it."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from spatial_relations_ros.core import SpatialRelationsError
from spatial_relations_ros.nodes.bag_player import BagPlayer
from spatial_relations_ros.ros.stop_request import StopRequest


def main(arguments: Sequence[str] | None = None) -> int:
    """Plays a bag; gives the exit code: 0 at its end or a signal, 2 when it cannot be read."""
    arguments = sys.argv if arguments is None else list(arguments)
    options = make_parser().parse_args(remove_ros_args(arguments)[1:])
    stop = StopRequest.by_signals()
    rclpy.init(args=list(arguments), signal_handler_options=SignalHandlerOptions.NO)
    node = Node('bag_player')
    try:
        return _play(node, options, stop)
    except SpatialRelationsError as error:
        print(f'error: {error}', file=sys.stderr)
        return 2
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def make_parser() -> argparse.ArgumentParser:
    """Of the command line, without ROS arguments."""
    parser = argparse.ArgumentParser(prog='play_bag', description=__doc__)
    parser.add_argument('bag', type=Path)
    parser.add_argument('--rate', type=float, default=1.0, help='times faster than recorded')
    parser.add_argument('--loop', action='store_true', help='start again at the end')
    parser.add_argument('--clock', action='store_true', help='publish the recorded time on /clock')
    parser.add_argument(
        '--wait', type=float, default=0.0, help='for subscribers at most, seconds; not without it'
    )
    parser.add_argument(
        '--wait-for',
        action='append',
        metavar='TOPIC',
        help='wait for subscribers of this topic only; can be repeated; else of all topics',
    )
    return parser


def _play(node: Node, options: argparse.Namespace, stop: StopRequest) -> int:
    player = BagPlayer(node, options.bag, rate=options.rate, has_clock=options.clock, stop=stop)
    for topic, msgtype in player.left_out.items():
        print(f'left out: {topic}, there is no {msgtype} here', file=sys.stderr)
    played = sorted(set(player.contents) - set(player.left_out))
    if options.wait:
        player.wait_for_subscribers(options.wait_for or played, options.wait)
    while True:
        num_published = player.play()
        print(f'{num_published} messages on {", ".join(played)}', flush=True)
        if not options.loop or stop.is_set():
            return 0


if __name__ == '__main__':
    sys.exit(main())
