"""Beliefs over time: hysteresis, and the words for what is not believed."""

import math

import pytest

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.perception.track_state import (
    Evidence,
    Observation,
    TrackMonitor,
    TrackState,
    TrackStateConfig,
)

SEC = 1_000_000_000
CONFIRMED = Observation(Evidence.CONFIRMED, 0.9)
WEAK = Observation(Evidence.WEAK, 0.3, 'little support')
HIDDEN = Observation(Evidence.NONE, math.nan, 'hidden')
CONTRADICTED = Observation(Evidence.CONTRADICTED, 0.04, 'no support (4 %)')
TRACKED, UNCERTAIN, LOST = TrackState


def run(monitor, observations, *, start_sec=0.0, step_sec=0.1):
    """The statuses of one object at a cloud each ``step_sec``."""
    return [
        monitor.update('cup', round((start_sec + idx * step_sec) * SEC), observation)
        for idx, observation in enumerate(observations)
    ]


def states(*arguments, **options):
    return [status.state for status in run(*arguments, **options)]


@pytest.mark.parametrize(
    ('first', 'state'),
    [(CONFIRMED, TRACKED), (HIDDEN, UNCERTAIN), (WEAK, UNCERTAIN), (CONTRADICTED, LOST)],
)
def test_the_first_cloud_decides_about_a_new_object(first, state):
    assert states(TrackMonitor(), [first]) == [state]


def test_one_contradiction_stops_the_use_and_one_confirmation_brings_it_back():
    clouds = [CONFIRMED, CONTRADICTED, CONFIRMED]
    assert states(TrackMonitor(), clouds) == [TRACKED, UNCERTAIN, TRACKED]


def test_it_takes_less_to_keep_a_belief_than_to_gain_one():
    assert states(TrackMonitor(), [CONFIRMED, WEAK, WEAK]) == [TRACKED] * 3
    assert states(TrackMonitor(), [CONFIRMED, CONTRADICTED, WEAK, WEAK])[2:] == [UNCERTAIN] * 2
    assert states(TrackMonitor(), [CONTRADICTED, WEAK]) == [LOST, LOST]


def test_an_object_without_support_is_lost_after_a_while():
    found = states(TrackMonitor(), [CONFIRMED] + [CONTRADICTED] * 7)
    assert found == [TRACKED] + [UNCERTAIN] * 5 + [LOST] * 2


def test_a_lost_object_must_be_confirmed_for_a_while_without_a_break():
    monitor = TrackMonitor()
    run(monitor, [CONTRADICTED])
    again = [CONFIRMED, CONFIRMED, CONTRADICTED, CONFIRMED, CONFIRMED, CONFIRMED, CONFIRMED]
    found = states(monitor, again, start_sec=1.0)
    assert found == [UNCERTAIN, UNCERTAIN, LOST, UNCERTAIN, UNCERTAIN, UNCERTAIN, TRACKED]


def test_occlusion_is_evidence_of_nothing():
    assert states(TrackMonitor(), [CONFIRMED] + [HIDDEN] * 50) == [TRACKED] * 51
    assert states(TrackMonitor(), [CONTRADICTED] + [HIDDEN] * 50) == [LOST] * 51


def test_a_doubted_object_is_uncertain_until_clouds_have_confirmed_it():
    monitor = TrackMonitor()
    run(monitor, [CONFIRMED])
    monitor.doubt('cup', 1.0, 'it jumped')
    found = run(monitor, [CONFIRMED] * 11, start_sec=0.1)
    assert [status.state for status in found] == [UNCERTAIN] * 10 + [TRACKED]
    assert found[4].reason == (
        'it jumped; confirmed for 0.4 s since, 1.0 s are needed, last good 0.5 s ago'
    )
    assert found[-1].reason == ''


def test_a_doubt_that_nobody_can_dispel_remains():
    monitor = TrackMonitor()
    run(monitor, [CONFIRMED])
    monitor.doubt('cup', 1.0, 'it jumped')
    found = run(monitor, [HIDDEN] * 30, start_sec=0.1)
    assert {status.state for status in found} == {UNCERTAIN}
    assert found[-1].reason == 'it jumped; hidden, last good 3.0 s ago'


def test_a_lost_object_that_is_doubted_stays_lost():
    monitor = TrackMonitor()
    run(monitor, [CONTRADICTED])
    monitor.doubt('cup', 1.0, 'it jumped')
    assert states(monitor, [HIDDEN], start_sec=0.1) == [LOST]


def test_the_reason_tells_how_long_ago_it_was_good():
    monitor = TrackMonitor()
    run(monitor, [CONFIRMED])
    (status,) = run(monitor, [CONTRADICTED], start_sec=2.3)
    assert status.state is LOST
    assert status.reason == 'no support (4 %), last good 2.3 s ago'
    assert status.last_good_ns == 0
    (never,) = run(TrackMonitor(), [CONTRADICTED])
    assert never.reason == 'no support (4 %), never confirmed'
    assert never.last_good_ns is None


def test_stamps_that_step_back_a_little_do_no_harm():
    monitor = TrackMonitor()
    run(monitor, [CONFIRMED], start_sec=5.0)
    (status,) = run(monitor, [CONTRADICTED], start_sec=4.5)
    assert status.reason.endswith('last good 0.0 s ago')


def test_objects_are_believed_apart_and_can_be_forgotten():
    monitor = TrackMonitor()
    monitor.update('cup', 0, CONFIRMED)
    monitor.update('bowl', 0, CONTRADICTED)
    assert monitor.update('cup', SEC, WEAK).state is TRACKED
    monitor.keep(frozenset({'bowl'}))
    assert monitor.update('cup', SEC, WEAK).state is UNCERTAIN
    assert monitor.update('bowl', SEC, WEAK).state is LOST
    monitor.clear()
    assert monitor.update('bowl', SEC, CONFIRMED).state is TRACKED


@pytest.mark.parametrize('wrong', [{'lost_after_sec': -1.0}, {'recover_sec': math.nan}])
def test_refuses_impossible_settings(wrong):
    with pytest.raises(ConfigError):
        TrackStateConfig(**wrong)
