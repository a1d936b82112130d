"""The card that accompanies weights."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from spatial_relations_ros.core import WeightsError, atomic_write

CARD_VERSION = 1
_KINDS: dict[str, type] = {
    'encoder': str, 'sha256': str, 'num_points': int, 'headings': int, 'steps': int,
    'config': dict, 'data': dict, 'retrieval': dict, 'calibration': dict, 'answers': dict,
    'versions': dict,
}  # fmt: skip


@dataclass(frozen=True)
class ModelCard:
    """Where weights come from and how good they are.

    Attributes:
        encoder: name of the network.
        num_points: points an object in training.
        headings: headings over which embeddings of scenes are averaged.
        sha256: of the weights file.
        config: name and settings of the training configuration.
        data: seed, counts and hash of the training data.
        steps: optimiser steps.
        retrieval: measured numbers on held-out objects.
        calibration: what the distances mean, in numbers; empty for weights without one.
        answers: ``slope`` and ``offset`` of the :class:`AnswerCalibration`, and what it was fitted
            to; empty without one.
        versions: of the libraries that trained it.
    """

    encoder: str
    num_points: int
    headings: int = 1
    sha256: str = ''
    config: dict[str, Any] = field(default_factory=dict)
    data: dict[str, Any] = field(default_factory=dict)
    steps: int = 0
    retrieval: dict[str, Any] = field(default_factory=dict)
    calibration: dict[str, Any] = field(default_factory=dict)
    answers: dict[str, Any] = field(default_factory=dict)
    versions: dict[str, str] = field(default_factory=dict)
    card_version: int = CARD_VERSION

    def write(self, path: Path) -> None:
        """Writes the card as JSON, atomically."""
        with atomic_write(path) as temporary:
            temporary.write_text(json.dumps(dataclasses.asdict(self), indent=2) + '\n')

    @staticmethod
    def read(path: Path) -> ModelCard:
        """Reads a card.

        Raises:
            WeightsError: when the card is missing, no JSON, of another version, or holds entries
                of the wrong kind.
        """
        try:
            content = json.loads(path.read_text())
        except FileNotFoundError:
            raise WeightsError(
                f'{path} is missing; weights need the JSON card that was written beside them'
            ) from None
        except (OSError, ValueError) as error:
            raise WeightsError(f'{path} is not a readable card: {error}') from error
        if not isinstance(content, dict) or content.get('card_version') != CARD_VERSION:
            raise WeightsError(f'{path} is not a card of version {CARD_VERSION}')
        known = {item.name for item in dataclasses.fields(ModelCard)}
        try:
            card = ModelCard(**{key: value for key, value in content.items() if key in known})
        except TypeError as error:
            raise WeightsError(f'{path} lacks entries: {error}') from error
        card._check(path)
        return card

    def _check(self, path: Path) -> None:
        """Refuses entries that loading or embedding would stumble over."""
        for name, kind in _KINDS.items():
            value = getattr(self, name)
            if not isinstance(value, kind) or isinstance(value, bool):
                raise WeightsError(f'{path}: {name} is {value!r}; expected {kind.__name__}')
        for name, least in (('num_points', 1), ('headings', 1), ('steps', 0)):
            if getattr(self, name) < least:
                raise WeightsError(f'{path}: {name} is {getattr(self, name)}, below {least}')
