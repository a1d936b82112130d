"""The short memory of stamped values against a naive one."""

from hypothesis import given, settings
from hypothesis import strategies as st

from spatial_relations_ros.perception.series import StampedSeries


def series(**changes):
    return StampedSeries(**({'history_ns': 100, 'max_samples': 50, 'jump_back_ns': 30} | changes))


@settings(deadline=None)
@given(st.lists(st.integers(1000, 1025), max_size=30), st.integers(990, 1035))
def test_finds_the_neighbours_in_time_in_any_order_of_arrival(stamps, query):
    memory = series()
    for order, stamp in enumerate(stamps):
        memory.add(stamp, (stamp, order))
    last = {stamp: order for order, stamp in enumerate(stamps)}
    before, after = memory.around(query)
    early = [stamp for stamp in last if stamp <= query]
    late = [stamp for stamp in last if stamp > query]
    assert before == ((max(early), (max(early), last[max(early)])) if early else None)
    assert after == ((min(late), (min(late), last[min(late)])) if late else None)
    assert len(memory) == len(last)


@settings(deadline=None)
@given(st.lists(st.integers(0, 10_000), min_size=1, max_size=60))
def test_is_bounded_in_number_and_age(stamps):
    memory = series(max_samples=5, jump_back_ns=10**6)
    for stamp in stamps:
        memory.add(stamp, stamp)
        assert 1 <= len(memory) <= 5
        assert memory.newest_ns - memory.oldest_ns <= 100


def test_a_jump_back_in_time_forgets_what_was_before():
    memory = series()
    memory.add(1000, 'old')
    memory.add(971, 'late')
    assert len(memory) == 2
    memory.add(969, 'new')
    assert memory.around(2000) == ((969, 'new'), None)
