"""Where a relation holds still."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spatial_relations_ros.core import ConfigError, Pose
from spatial_relations_ros.evaluation.demonstrations import (
    DemonstrationFinder,
    HoldConfig,
    RelationSample,
    find_demonstrations,
)

RATE = 10
START_NS = 1_700_000_000_000_000_000


def samples(*places, start_ns=START_NS, first=0):
    """Ten frames a second with the relative at x metres; None where it is not seen."""
    return [
        RelationSample(
            first + idx,
            start_ns + round(idx * 1e9 / RATE),
            None if x is None else Pose(np.array([x, 0.0, 0.0])),
        )
        for idx, x in enumerate(places)
    ]


def frames(found):
    return [(item.first_frame, item.settled_frame, item.last_frame) for item in found]


def test_a_relation_that_holds_still_for_a_second():
    moving = [0.1 * step for step in range(1, 10)]
    still = [1.0] * 15
    found = find_demonstrations(samples(*moving, *still, *(1.0 + step for step in moving)))
    assert frames(found) == [(9, 19, 23)]
    assert found[0].start_ns == START_NS + 900_000_000
    assert found[0].end_ns == START_NS + 2_300_000_000


def test_a_relation_that_holds_too_short_is_none():
    assert find_demonstrations(samples(*[0.0] * 10, 1.0, 2.0, 3.0)) == ()


def test_each_relation_that_is_shown_counts():
    found = find_demonstrations(samples(*[0.0] * 12, *[0.2] * 3, *[0.5] * 12))
    assert frames(found) == [(0, 10, 11), (15, 25, 26)]


def test_the_last_one_needs_no_end():
    finder = DemonstrationFinder()
    given_now = [finder.add(sample) for sample in samples(*[0.0] * 12)]
    assert given_now[:10] == [None] * 10
    assert frames([given_now[10]]) == [(0, 10, 10)]
    assert frames(finder.found) == [(0, 10, 11)]


def test_errors_of_the_tracker_and_short_gaps_do_not_end_it():
    places = [0.0] * 8 + [0.3] + [0.0] * 8 + [None] * 4 + [0.005] * 8
    assert frames(find_demonstrations(samples(*places))) == [(0, 10, 28)]


def test_an_error_in_the_first_frame_does_not_hide_it():
    assert frames(find_demonstrations(samples(0.5, *[0.0] * 20))) == [(1, 11, 20)]


def test_a_long_absence_ends_it():
    places = [0.0] * 12 + [None] * 7 + [0.0] * 12
    assert frames(find_demonstrations(samples(*places))) == [(0, 10, 11), (19, 29, 30)]


def test_a_slow_drift_is_no_hold():
    """5 cm a second: more than a centimetre away within the second."""
    assert find_demonstrations(samples(*np.arange(0.0, 1.0, 0.005))) == ()


def test_turning_ends_it_too():
    def turned(angle):
        quat = np.array([np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)])
        return Pose(np.zeros(3), quat)

    turns = [RelationSample(i, i * 100_000_000, turned(0.2 * (i >= 12))) for i in range(24)]
    assert frames(find_demonstrations(turns)) == [(0, 10, 11), (12, 22, 23)]


def test_a_bag_that_starts_again_shows_it_again():
    again = samples(*[0.0] * 12) + samples(*[0.0] * 12, first=12)
    assert frames(find_demonstrations(again)) == [(0, 10, 11), (12, 22, 23)]


@given(st.lists(st.sampled_from([0.0, 0.004, 0.3, 0.6, None]), max_size=80))
def test_found_ones_are_long_apart_and_still(places):
    """By the definition: ends are still, settled frames a second after the first."""
    taken = samples(*places)
    found = find_demonstrations(taken)
    for item in found:
        assert item.first_frame + RATE <= item.settled_frame <= item.last_frame
        x = places[item.first_frame]
        away = [
            idx
            for idx in range(item.first_frame, item.last_frame + 1)
            if places[idx] is None or abs(places[idx] - x) > 0.01
        ]
        runs = np.split(away, np.flatnonzero(np.diff(away) > 1) + 1) if away else []
        assert all(len(run) < 5 for run in runs)
        assert not {item.first_frame, item.last_frame} & set(away)
    for before, after in itertools.pairwise(found):
        assert before.last_frame < after.first_frame
    for length in (11 * [x] for x in (0.0, 0.3)):
        assert find_demonstrations(samples(*length))


@pytest.mark.parametrize('wrong', [{'hold_sec': 0.0}, {'shift': -1.0}, {'turn_rad': np.nan}])
def test_refuses_impossible_settings(wrong):
    with pytest.raises(ConfigError, match='positive'):
        HoldConfig(**wrong)
