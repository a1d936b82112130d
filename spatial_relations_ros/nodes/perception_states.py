"""What perception_node reports about its clouds and objects on /diagnostics."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping

from spatial_relations_ros.perception.assembler import FrameAssembler
from spatial_relations_ros.perception.border import FrameResult
from spatial_relations_ros.perception.track_state import TrackState
from spatial_relations_ros.ros.diagnostics import OK, WARN, State
from spatial_relations_ros.ros.latency import Latencies

AGE = 'age_sec'


def clouds_state(assembler: FrameAssembler, latencies: Latencies) -> State:
    """How many clouds were handled and how fast, and how many were given up, by reason."""
    dropped = assembler.dropped
    values: dict[str, object] = {'dropped': dropped.total(), 'waiting': assembler.num_clouds}
    values |= latencies.values()
    values |= {f'dropped: {reason}': count for reason, count in sorted(dropped.items())}
    return State(OK, f'{dropped.total()} dropped' if dropped else 'none dropped', values)


def objects_state(latest: FrameResult | None, age_sec: float) -> State:
    """How far each object is believed.

    Args:
        latest: the last result; None before the first.
        age_sec: how long ago it was made.
    """
    if latest is None:
        return State(OK, 'waiting for the first cloud')
    values: dict[str, object] = {AGE: f'{age_sec:.1f}'}
    values |= latest.rejected
    values |= {key: _state_words(latest, key) for key in sorted(latest.states)}
    if latest.problem is not None:
        return State(WARN, latest.problem, values)
    counts = Counter(status.state for status in latest.states.values())
    message = ', '.join(f'{counts[state]} {state}' for state in TrackState if counts[state])
    is_good = set(counts) <= {TrackState.TRACKED}
    return State(OK if is_good else WARN, message or 'no objects', values)


def _state_words(result: FrameResult, object_id: str) -> str:
    status = result.states[object_id]
    if status.reason:
        return f'{status.state}: {status.reason}'
    item = result.objects[object_id]
    support = 'not checked' if math.isnan(status.support) else f'{100 * status.support:.0f} %'
    return f'{status.state}: {item.source.name}, support {support}'


def read_states(values: Mapping[str, str]) -> dict[str, tuple[TrackState | None, str]]:
    """The states of objects among the values of ``objects_state``, with the words beside them.

    An object whose pose could not even be read has no state.
    """
    states: dict[str, tuple[TrackState | None, str]] = {}
    for object_id, text in values.items():
        if object_id == AGE:
            continue
        word, _, reason = text.partition(': ')
        if word in TrackState.__members__:
            states[object_id] = TrackState[word], reason
        else:
            states[object_id] = None, text
    return states
