"""What a way of imitating answers to a case."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TypedDict

from spatial_relations_ros.core import Pose, Scene
from spatial_relations_ros.evaluation.generalization.cases import Case


@dataclass(frozen=True, eq=False)
class Attempt:
    """An answer, not yet judged.

    Attributes:
        poses: world_from_object of base and relative; None when it refused to answer.
        claimed: whether it calls itself a success; None where it cannot tell.
        confidence: its own probability of the right relation; None where it has none.
        difference: how far its arrangement is from the demonstration's, as far as it knows.
        distance, initial_distance: under its own measure, after and before.
        num_steps: optimiser steps, or samples that were compared.
        seconds: wall time.
        cpu_seconds: of the process's threads together.
        message: its own words.
    """

    poses: tuple[Pose, Pose] | None
    claimed: bool | None
    confidence: float | None
    distance: float
    initial_distance: float
    num_steps: int
    seconds: float
    cpu_seconds: float
    message: str = ''
    difference: float | None = None

    def scene(self, case: Case) -> Scene:
        """The test scene with the objects where the answer says, unchanged without one."""
        return case.test if self.poses is None else case.test.with_poses(*self.poses)


class Times(TypedDict):
    """How long something took."""

    seconds: float
    cpu_seconds: float


class Stopwatch:
    """Wall and processor time from its making on."""

    def __init__(self) -> None:
        self._wall, self._cpu = time.perf_counter(), time.process_time()

    def times(self) -> Times:
        """``seconds`` and ``cpu_seconds`` so far."""
        return {
            'seconds': time.perf_counter() - self._wall,
            'cpu_seconds': time.process_time() - self._cpu,
        }
