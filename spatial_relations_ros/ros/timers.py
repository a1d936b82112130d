"""Timers of the machine's own time."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.callback_groups import CallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.timer import Timer


def steady_timer(
    node: Node,
    period_sec: float,
    callback: Callable[[], None],
    *,
    group: CallbackGroup | None = None,
) -> Timer:
    """A timer that goes on where ``use_sim_time`` is set and no ``/clock`` runs, or a slow one."""
    clock = Clock(clock_type=ClockType.STEADY_TIME)
    return node.create_timer(period_sec, callback, callback_group=group, clock=clock)
