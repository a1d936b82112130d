"""What browsers may ask is checked before anybody acts on it."""

from __future__ import annotations

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spatial_relations_ros.nodes.panel.commands import (
    CancelCommand,
    CommandError,
    ForgetCommand,
    ImitateCommand,
    RememberCommand,
    read_command,
)

IMITATE = {'id': 1, 'type': 'imitate', 'reference': ['plate', 'cup'], 'test': ['tray', 'mug']}
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)


def read(**content: object) -> object:
    return read_command(json.dumps(content))[1]


def test_commands_are_read() -> None:
    assert read(**IMITATE) == ImitateCommand(
        ('plate', 'cup'), '', ('tray', 'mug'), ('mug',), 1, False
    )
    named = {'id': 2, 'type': 'imitate', 'reference_name': ' shown ', 'test': ['tray', 'mug']}
    assert read(**named, movable='both', answers=3, keep_heading=True) == ImitateCommand(
        (), 'shown', ('tray', 'mug'), ('tray', 'mug'), 3, True
    )
    assert read(**named, time_budget=2).time_budget_sec == 2.0
    assert read(id=3, type='cancel') == CancelCommand()
    remembered = read(id=4, type='remember', name='x', objects=['a', 'b'])
    assert remembered == RememberCommand('x', ('a', 'b'), replace=False)
    assert read_command('{"id": 5, "type": "forget", "name": "x"}') == (5, ForgetCommand('x'))


@pytest.mark.parametrize(
    ('change', 'reason'),
    [
        ({'id': '1'}, 'id: expected a whole number'),
        ({'id': True}, 'id: expected a whole number'),
        ({'type': 'shutdown'}, 'type: expected one of imitate, cancel'),
        ({'type': ['imitate']}, 'type: expected one of'),
        ({'test': ['mug', 'mug']}, 'both'),
        ({'test': ['mug']}, 'choose two objects'),
        ({'test': ['tray', '']}, 'a name is missing'),
        ({'test': ['tray', 7]}, 'a name is missing'),
        ({'test': ['tray', 'x' * 201]}, 'at most 200'),
        ({'test': ['tray', 'a\x00b']}, 'can be shown'),
        ({'reference_name': 'shown'}, 'not both'),
        ({'movable': 'table'}, 'movable: expected'),
        ({'movable': {}}, 'movable: expected'),
        ({'answers': 0}, 'answers: expected 1 to 10'),
        ({'answers': 1.5}, 'answers: expected'),
        ({'time_budget': -1}, 'time_budget: expected seconds, 0 to 600'),
        ({'time_budget': float('nan')}, 'time_budget: expected'),
        ({'time_budget': True}, 'time_budget: expected'),
        ({'keep_heading': 1}, 'true or false'),
    ],
)
def test_what_is_none_is_refused_with_the_reason(change: dict[str, object], reason: str) -> None:
    with pytest.raises(CommandError, match=reason):
        read(**{**IMITATE, **change})


@settings(max_examples=50)
@given(st.text() | VALUES.map(json.dumps) | st.builds(lambda v: json.dumps({**IMITATE, **v}),
       st.dictionaries(st.sampled_from([*IMITATE, 'movable', 'answers']), VALUES)))  # fmt: skip
def test_no_text_does_anything_else(text: str) -> None:
    try:
        number, command = read_command(text)
    except CommandError:
        return
    assert isinstance(number, int)
    assert command is not None


def test_deep_nesting_is_refused() -> None:
    with pytest.raises(CommandError, match='no JSON'):
        read_command('[' * 100_000)
