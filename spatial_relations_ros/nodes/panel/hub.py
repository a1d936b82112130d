"""The browsers that look at the panel, and what each of them is still to get."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Mapping
from typing import Any

MAX_WAITING = 64


def as_json(content: Mapping[str, Any]) -> str:
    """JSON text; NaN and infinities, which JSON has not, are an error of the caller."""
    return json.dumps(content, separators=(',', ':'), allow_nan=False)


class Mailbox:
    """What waits for one browser: of each subject the newest message only.

    A slow browser thus misses what is past instead of lagging behind, and memory stays bounded: of
    too many subjects the oldest is dropped.
    """

    def __init__(self) -> None:
        self._waiting: dict[str, str] = {}
        self._filled = asyncio.Event()

    def post(self, subject: str, text: str) -> None:
        """Puts a message in, in place of an older one of the subject."""
        self._waiting.pop(subject, None)
        if len(self._waiting) >= MAX_WAITING:
            del self._waiting[next(iter(self._waiting))]
        self._waiting[subject] = text
        self._filled.set()

    async def take(self) -> list[str]:
        """Waits for messages and takes all of them, the oldest first."""
        await self._filled.wait()
        self._filled.clear()
        texts = list(self._waiting.values())
        self._waiting.clear()
        return texts


class Hub:
    """All browsers; who comes late gets the latest message of each subject."""

    def __init__(self) -> None:
        self._mailboxes: set[Mailbox] = set()
        self._latest: dict[str, str] = {}

    def __len__(self) -> int:
        return len(self._mailboxes)

    def join(self) -> Mailbox:
        """A mailbox for a new browser."""
        mailbox = Mailbox()
        for subject, text in self._latest.items():
            mailbox.post(subject, text)
        self._mailboxes.add(mailbox)
        return mailbox

    def leave(self, mailbox: Mailbox) -> None:
        """Forgets a browser."""
        self._mailboxes.discard(mailbox)

    def publish(
        self, subject: str, content: Mapping[str, Any], *, only_changes: bool = False
    ) -> None:
        """Sends a message of a few fixed subjects to all browsers, and keeps it for later ones.

        Args:
            subject: of the message, its ``type``.
            content: of the message.
            only_changes: sends nothing when it says what the last one said.
        """
        text = as_json({'type': subject, **content})
        if only_changes and self._latest.get(subject) == text:
            return
        self._latest[subject] = text
        for mailbox in self._mailboxes:
            mailbox.post(subject, text)
