"""How far in time each object's poses have come."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

MAX_OBJECTS = 64


@dataclass
class _Heard:
    newest_ns: int
    # The latest stamp that went with a cloud; None before the first.
    taken_ns: int | None = None
    is_awaited: bool = True


class HeardObjects:
    """The newest stamp of each object, of those heard of last.

    Args:
        jump_back_ns: a stamp older than the newest by more than this is a restart of the clock.
    """

    def __init__(self, jump_back_ns: int) -> None:
        self._jump_back_ns = jump_back_ns
        self._objects: dict[str, _Heard] = {}

    def hear(self, object_id: str, stamp_ns: int) -> bool:
        """Notes a pose; True when its clock has jumped back."""
        # Taken out and put back: the dict stays in order of the last word of each object.
        heard = self._objects.pop(object_id, None)
        is_jump = heard is not None and stamp_ns < heard.newest_ns - self._jump_back_ns
        if heard is None or is_jump:
            heard = _Heard(stamp_ns)
        heard.newest_ns = max(heard.newest_ns, stamp_ns)
        heard.is_awaited = True
        self._objects[object_id] = heard
        if len(self._objects) > MAX_OBJECTS:
            del self._objects[next(iter(self._objects))]
        return is_jump

    def missing_at(self, stamp_ns: int) -> list[str]:
        """The awaited objects without a pose at or after a time."""
        return [
            object_id
            for object_id, heard in self._objects.items()
            if heard.is_awaited and heard.newest_ns < stamp_ns
        ]

    def give_up(self, object_ids: Iterable[str]) -> None:
        """Objects are not awaited again until they are heard of."""
        for object_id in object_ids:
            self._objects[object_id].is_awaited = False

    def is_due(self, object_id: str, track_ns: int, cloud_ns: int) -> bool:
        """Whether a pose goes with a cloud: up to its time, and the first one at or after it.

        Args:
            object_id: whose pose it is.
            track_ns: its stamp.
            cloud_ns: the cloud's stamp.
        """
        heard = self._objects.get(object_id)
        if heard is None:  # forgotten since: nothing is held back for it
            return True
        is_due = track_ns <= cloud_ns or heard.taken_ns is None or heard.taken_ns < cloud_ns
        if is_due and (heard.taken_ns is None or track_ns > heard.taken_ns):
            heard.taken_ns = track_ns
        return is_due

    def forget_after(self, stamp_ns: int) -> None:
        """Forgets objects whose newest pose is later, as after a jump of the clock."""
        self._objects = {
            object_id: heard
            for object_id, heard in self._objects.items()
            if heard.newest_ns <= stamp_ns
        }
