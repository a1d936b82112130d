"""Sensors, trackers and clocks that fail, before a perception node that must not."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from ros_graph import Graph
from spatial_relations_msgs.msg import TrackedObjectArray

from spatial_relations_ros.perception.series import NS_PER_SEC

from .cell import START_NS, WIDTH, Cell
from .conftest import Faults

pytestmark = pytest.mark.ros

MAX_AGE_SEC = 1.0


@pytest.fixture(scope='module')
def cell(graph: Graph, tmp_path_factory: pytest.TempPathFactory) -> Cell:
    cell = Cell(graph, tmp_path_factory.mktemp('models'), max_age=MAX_AGE_SEC)
    cell.wait_well()
    return cell


@pytest.fixture(autouse=True)
def _well(cell: Cell) -> None:
    cell.wait_well()


def send(cell: Cell, *, tracks: Callable[[TrackedObjectArray], None]) -> None:
    """A cloud with poses that something has been done to."""
    stamp_ns = cell.tick()
    message = cell.table.tracks(stamp_ns)
    tracks(message)
    cell.tracks.publish(message)
    cell.clouds.publish(cell.table.cloud(stamp_ns))


def test_the_sensor_stops_and_comes_back(cell: Cell, faults: Faults) -> None:
    with faults('sensor stops, the tracker goes on') as row:
        row.said = cell.wait_refused(
            'is the sensor still running?',
            lambda: cell.tracks.publish(cell.table.tracks(cell.tick())),
        )
        assert f'max_age is {MAX_AGE_SEC:g} s' in row.said
        row.is_over()
        row.is_back(cell.wait_well())


def test_the_tracker_stops_and_comes_back(cell: Cell, faults: Faults) -> None:
    with faults('tracker stops, the sensor goes on') as row:
        row.said = cell.wait_refused(
            'the last tracked pose is', lambda: cell.clouds.publish(cell.table.cloud(cell.tick()))
        )
        row.is_over()
        row.is_back(cell.wait_well())


def test_swapped_ids_are_refused(cell: Cell, faults: Faults) -> None:
    def swap(message: TrackedObjectArray) -> None:
        box, post = message.objects
        box.pose.position, post.pose.position = post.pose.position, box.pose.position

    with faults('tracker swaps two ids') as row:
        first_ns = cell.stamp_ns + 1
        row.said = cell.wait_refused('swapped', lambda: send(cell, tracks=swap))
        for _ in range(5):
            send(cell, tracks=swap)
            assert not cell.ask().success
        last_ns = cell.stamp_ns
        row.is_over()
        row.is_back(cell.wait_well())
    cell.graph.wait(lambda: max(cell.published) > last_ns, 'a published scene')
    # Not even for one frame.
    assert not [stamp for stamp in cell.published if first_ns <= stamp <= last_ns]


@pytest.mark.parametrize(
    ('fault', 'quat_w', 'words'),
    [('pose is NaN', math.nan, 'finite'), ('quaternion of norm 2', 2.0, 'norm 2')],
)
def test_a_pose_that_is_none_costs_its_object_only(
    cell: Cell, faults: Faults, fault: str, quat_w: float, words: str
) -> None:
    def spoil(message: TrackedObjectArray) -> None:
        message.objects[1].pose.orientation.w = quat_w

    with faults(fault) as row:
        row.said = cell.wait_refused('post: ', lambda: send(cell, tracks=spoil))
        assert 'known objects: box' in row.said

        def is_told() -> bool:
            send(cell, tracks=spoil)
            return words in cell.diagnostic('objects').get('post', '')

        cell.graph.wait(is_told, f'{words!r} ({cell.diagnostic("objects")})')
        row.is_over()
        row.is_back(cell.wait_well())


def test_a_cloud_of_a_frame_that_nobody_knows(cell: Cell, faults: Faults) -> None:
    def show() -> None:
        stamp_ns = cell.tick()
        cell.tracks.publish(cell.table.tracks(stamp_ns))
        cell.clouds.publish(cell.table.cloud(stamp_ns, frame_id='other_camera'))

    with faults('cloud of another frame without a transform') as row:
        row.said = cell.wait_refused('other_camera', show)
        cell.graph.wait(
            lambda: 'other_camera' in cell.diagnostic('objects')['message'], 'a diagnosis'
        )
        row.is_over()
        row.is_back(cell.wait_well())


def test_a_cloud_that_is_ten_times_larger(cell: Cell, faults: Faults) -> None:
    large = cell.table.measured(math.ceil(math.sqrt(10.0) * WIDTH))
    assert large.size > 9.9 * cell.table.cloud(0).width * cell.table.cloud(0).height * 3

    def is_seen() -> bool:
        stamp_ns = cell.tick()
        cell.tracks.publish(cell.table.tracks(stamp_ns))
        cell.clouds.publish(cell.table.cloud(stamp_ns, xyz=large))
        answer = cell.ask()
        return bool(answer.success and answer.scene.header.stamp.sec == stamp_ns // NS_PER_SEC)

    with faults('cloud of ten times as many points') as row:
        cell.graph.wait(is_seen, 'a scene of the large cloud')
        row.said = f'support {cell.last.scene.base.support:.2f}, as of the others'
        assert cell.last.scene.base.support > 0.8
        row.is_over()
        row.is_back(cell.wait_well())


@pytest.mark.parametrize('jump_sec', [3600, -7200, -3])
def test_the_clock_jumps(cell: Cell, faults: Faults, jump_sec: int) -> None:
    with faults(f'stamps jump by {jump_sec} s') as row:
        cell.stamp_ns += jump_sec * NS_PER_SEC
        row.is_over()
        row.is_back(cell.wait_well())
        row.said = 'goes on with the new stamps'


def test_clouds_that_come_while_none_is_read_are_not_kept(cell: Cell, faults: Faults) -> None:
    """A burst without poses: of what waits the newest is taken, the others are counted."""
    with faults('200 clouds at once') as row:
        before = int(cell.diagnostic('clouds')['dropped'])
        for _ in range(200):
            cell.clouds.publish(cell.table.cloud(cell.tick()))
        row.is_over()
        row.is_back(cell.wait_well())
        cell.graph.wait(
            lambda: int(cell.diagnostic('clouds')['waiting']) <= 5, 'the end of the queue'
        )
        dropped = int(cell.diagnostic('clouds')['dropped']) - before
        row.said = f'{dropped} dropped by the node, the others by the queue of DDS'


def test_memory_is_bounded(cell: Cell, faults: Faults) -> None:
    """After all of the above; the last of this file."""

    def memory_mb() -> float:
        return float(cell.diagnostic('process')['memory_mb'])

    with faults('poses of 2,000 objects, 300 clouds, stamps of a year') as row:
        before = memory_mb()
        for idx in range(300):
            cell.stamp_ns += NS_PER_SEC * 100_000
            stamp_ns = cell.tick()
            message = cell.table.tracks(stamp_ns)
            for number in range(7):
                ghost = cell.table.tracks(stamp_ns).objects[0]
                ghost.object_id = f'ghost_{7 * idx + number}'
                message.objects.append(ghost)
            cell.tracks.publish(message)
            cell.clouds.publish(cell.table.cloud(stamp_ns))
        cell.stamp_ns = START_NS
        row.is_over()
        row.is_back(cell.wait_well())
        growth = memory_mb() - before
        assert growth < 100.0
        row.said = f'{before:.0f} MB before, {growth:+.0f} MB after'
