"""What a browser may ask of the panel, read from JSON and checked."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from spatial_relations_ros.core import SpatialRelationsError

MAX_NAME_LENGTH = 200
MAX_ANSWERS = 10
# Of a request, seconds.
MAX_TIME_BUDGET_SEC = 600.0
MOVABLE = ('relative', 'base', 'both')


class CommandError(SpatialRelationsError):
    """A message of a browser that is no command of the panel.

    Attributes:
        number: that the browser gave the message; None where there is none.
    """

    number: int | None = None


@dataclass(frozen=True)
class ImitateCommand:
    """Imitate a relation.

    Attributes:
        reference_ids: base and relative that are seen; empty with a name.
        reference_name: of a remembered relation; empty with ids.
        test_ids: base and relative to place.
        movable_ids: which of these may move.
        num_answers: at most so many.
        keep_heading: also keep the demonstration's direction.
        time_budget_sec: that it may take; 0 for the node's own.
    """

    reference_ids: tuple[str, ...]
    reference_name: str
    test_ids: tuple[str, str]
    movable_ids: tuple[str, ...]
    num_answers: int
    keep_heading: bool
    time_budget_sec: float = 0.0


@dataclass(frozen=True)
class CancelCommand:
    """End the imitation that runs, with its best answer so far."""


@dataclass(frozen=True)
class RememberCommand:
    """Remember the relation of two objects under a name."""

    name: str
    object_ids: tuple[str, str]
    replace: bool


@dataclass(frozen=True)
class ForgetCommand:
    """Forget a remembered relation."""

    name: str


Command = ImitateCommand | CancelCommand | RememberCommand | ForgetCommand


def read_command(text: str) -> tuple[int, Command]:
    """The number that the browser gave its message, and the command in it.

    Raises:
        CommandError: for anything that is no command; says what was expected.
    """
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise CommandError(f'no JSON: {error}') from error
    if not isinstance(content, dict):
        raise CommandError(f'expected an object, got {type(content).__name__}')
    number = content.get('id')
    if type(number) is not int or not 0 <= number < 2**53:
        raise CommandError('id: expected a whole number')
    kind = content.get('type')
    try:
        if not isinstance(kind, str) or kind not in _READERS:
            raise CommandError(f'type: expected one of {", ".join(_READERS)}')
        return number, _READERS[kind](content)
    except CommandError as error:
        error.number = number
        raise


def _imitate(given: Mapping[str, Any]) -> ImitateCommand:
    test_ids = _pair(given, 'test')
    if 'reference' in given and 'reference_name' in given:
        raise CommandError('give reference or reference_name, not both')
    is_named = 'reference_name' in given
    reference_ids = () if is_named else _pair(given, 'reference')
    name = _name(given, 'reference_name') if is_named else ''
    movable = given.get('movable', 'relative')
    if movable not in MOVABLE:
        raise CommandError(f'movable: expected one of {", ".join(MOVABLE)}')
    num_answers = given.get('answers', 1)
    if type(num_answers) is not int or not 1 <= num_answers <= MAX_ANSWERS:
        raise CommandError(f'answers: expected 1 to {MAX_ANSWERS}')
    movable_ids = {'base': test_ids[:1], 'relative': test_ids[1:], 'both': test_ids}[movable]
    return ImitateCommand(
        reference_ids,
        name,
        test_ids,
        movable_ids,
        num_answers,
        _flag(given, 'keep_heading'),
        _time_budget(given),
    )


def _time_budget(given: Mapping[str, Any]) -> float:
    seconds = given.get('time_budget', 0)
    if type(seconds) not in (int, float) or not 0.0 <= seconds <= MAX_TIME_BUDGET_SEC:
        raise CommandError(f'time_budget: expected seconds, 0 to {MAX_TIME_BUDGET_SEC:g}')
    return float(seconds)


def _cancel(_: Mapping[str, Any]) -> CancelCommand:
    return CancelCommand()


def _remember(given: Mapping[str, Any]) -> RememberCommand:
    return RememberCommand(_name(given, 'name'), _pair(given, 'objects'), _flag(given, 'replace'))


def _forget(given: Mapping[str, Any]) -> ForgetCommand:
    return ForgetCommand(_name(given, 'name'))


_READERS: dict[str, Callable[[Mapping[str, Any]], Command]] = {
    'imitate': _imitate,
    'cancel': _cancel,
    'remember': _remember,
    'forget': _forget,
}


def _pair(given: Mapping[str, Any], key: str) -> tuple[str, str]:
    value = given.get(key)
    if not isinstance(value, list) or len(value) != 2:
        raise CommandError(f'{key}: choose two objects, base and relative')
    base, relative = (_word(item, key) for item in value)
    if base == relative:
        raise CommandError(f'{key}: base and relative are both {base!r}; choose two objects')
    return base, relative


def _name(given: Mapping[str, Any], key: str) -> str:
    return _word(given.get(key), key)


def _word(value: Any, key: str) -> str:
    word = value.strip() if isinstance(value, str) else ''
    if not word:
        raise CommandError(f'{key}: a name is missing')
    if len(word) > MAX_NAME_LENGTH or not word.isprintable():
        raise CommandError(f'{key}: expected at most {MAX_NAME_LENGTH} letters that can be shown')
    return word


def _flag(given: Mapping[str, Any], key: str) -> bool:
    value = given.get(key, False)
    if not isinstance(value, bool):
        raise CommandError(f'{key}: expected true or false')
    return value
