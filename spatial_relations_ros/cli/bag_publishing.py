"""``relations replay --publish``: hands a bag to the node that publishes it."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from pathlib import Path

import typer


def publish_bag(bags: Sequence[Path], *, rate: float, loop: bool, clock: bool) -> int:
    """Starts ``play_bag`` as a process and waits for its end; gives its exit code.

    Raises:
        typer.BadParameter: for several bags.
        ConfigError: where ROS or the node is not installed.
    """
    from spatial_relations_ros.core import ConfigError, executable_path
    from spatial_relations_ros.core.interrupts import run_program

    if len(bags) != 1:
        raise typer.BadParameter('--publish takes one bag')
    if importlib.util.find_spec('rclpy') is None:
        raise ConfigError(
            '--publish needs ROS 2: rclpy is not installed or not sourced; a replay without it '
            'needs none'
        )
    command = [str(executable_path('play_bag')), str(bags[0]), '--rate', str(rate)]
    command += [flag for flag, is_on in (('--loop', loop), ('--clock', clock)) if is_on]
    return run_program(command)
