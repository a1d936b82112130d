"""How latencies are kept."""

from __future__ import annotations

from spatial_relations_ros.ros.latency import MAX_PENDING, Latencies


def test_messages_that_are_done_are_counted_and_timed():
    latencies = Latencies()
    for stamp_ns in (1, 2, 3):
        latencies.arrived(stamp_ns)
    latencies.done(1)
    latencies.done(3)
    values = latencies.values()
    assert values['handled'] == 2
    assert 0.0 <= float(str(values['latency_median_ms'])) <= float(str(values['latency_max_ms']))
    latencies.clear()
    assert latencies.values() == {'handled': 0}


def test_messages_that_never_get_done_do_not_pile_up():
    latencies = Latencies()
    for stamp_ns in range(10 * MAX_PENDING):
        latencies.arrived(stamp_ns)
    latencies.done(0)  # forgotten: counted, not timed
    assert latencies.values() == {'handled': 1}
