"""What is said of damaged relations, which are left out while all others can be used."""

from __future__ import annotations

from collections.abc import Callable, Mapping


def is_storable_text(text: str) -> bool:
    """Whether a text has a form in UTF-8: arguments of a command line that are none have not."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def read_text(data: bytes) -> str:
    """A text of the file; bytes that are no UTF-8 as arguments of a command line have them."""
    return data.decode(errors='surrogateescape')


def damaged_text(relation_id: int, name: str, reason: str) -> str:
    """Names a damaged relation, says why it is one and what to do.

    Args:
        relation_id: tells it when its name cannot be shown.
        name: as :func:`read_text` has read it.
        reason: what is wrong beside the name.
    """
    if is_storable_text(name):
        return f'the remembered relation {name!r} is damaged ({reason}); replace or forget it'
    raw = name.encode(errors='surrogateescape')
    return (
        f'the remembered relation of id {relation_id} is damaged (its name {raw!r} is no valid '
        'UTF-8); forget it by that name'
    )


class DamageReport:
    """Warns of each damaged relation once.

    Args:
        warn: told in words.
    """

    def __init__(self, warn: Callable[[str], None]) -> None:
        self._warn = warn
        # Ids are never used twice.
        self._told: set[int] = set()

    def tell(self, damaged: Mapping[int, str]) -> None:
        """Warns of those that are new, by id, as :func:`damaged_text` says it."""
        for relation_id in sorted(damaged.keys() - self._told):
            self._told.add(relation_id)
            self._warn(f'{damaged[relation_id]}. It is left out until then')
