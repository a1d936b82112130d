"""``relations bench live``: starts the benchmark, which needs ROS, as a process."""

from __future__ import annotations

import importlib.util
import json
import sys
from collections.abc import Sequence


def run_live_bench(arguments: Sequence[str]) -> int:
    """Runs the live benchmark and waits for its end; gives its exit code.

    Args:
        arguments: of ``python -m spatial_relations_ros.nodes.live_bench``.

    Raises:
        ConfigError: where ROS is not installed.
    """
    from spatial_relations_ros.cli.provenance import provenance
    from spatial_relations_ros.core import ConfigError
    from spatial_relations_ros.core.interrupts import run_program

    if importlib.util.find_spec('rclpy') is None:
        raise ConfigError(
            'bench live needs ROS 2: rclpy is not installed or not sourced; '
            'relations bench --step perception needs none'
        )
    command = [
        sys.executable, '-m', 'spatial_relations_ros.nodes.live_bench', *arguments,
        '--provenance', json.dumps(provenance()),
    ]  # fmt: skip
    return run_program(command)
