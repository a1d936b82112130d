"""A perception node on simulated time, as with a bag that is played with --clock."""

from __future__ import annotations

import pytest
from ros_graph import Graph

from spatial_relations_ros.perception.series import NS_PER_SEC

from .cell import Cell
from .conftest import Faults

pytestmark = pytest.mark.ros


class StillClock(Cell):
    """Sensor and tracker go on while nobody publishes /clock."""

    has_clock = False

    def send_clock(self) -> None:
        if self.has_clock:
            super().send_clock()


@pytest.fixture(scope='module')
def cell(graph: Graph, tmp_path_factory: pytest.TempPathFactory) -> StillClock:
    return StillClock(graph, tmp_path_factory.mktemp('models'), use_sim_time=True)


def test_clouds_are_handled_before_the_clock_runs(cell: StillClock, faults: Faults) -> None:
    assert not cell.ask().success  # it has started
    with faults('use_sim_time without a /clock') as row:
        row.is_over()
        row.is_back(cell.wait_well())
        row.said = 'stamps of clouds and poses count'
    with faults('the same, and the tracker stops') as row:
        row.said = cell.wait_refused(
            'the last tracked pose is', lambda: cell.clouds.publish(cell.table.cloud(cell.tick()))
        )
        row.is_over()
        row.is_back(cell.wait_well())


@pytest.mark.parametrize('jump_sec', [-30, 600])
def test_the_clock_jumps_with_the_stamps(cell: StillClock, faults: Faults, jump_sec: int) -> None:
    cell.has_clock = True
    cell.wait_well()
    name = 'a bag that starts again' if jump_sec < 0 else f'/clock jumps by {jump_sec} s'
    with faults(f'use_sim_time: {name}') as row:
        cell.stamp_ns += jump_sec * NS_PER_SEC
        row.is_over()
        row.is_back(cell.wait_well())
        row.said = 'goes on with the new time'
