"""Named training configurations."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from spatial_relations_ros.core import ConfigError

LOSSES = ('all_pairs', 'neighbourhood', 'multi_similarity', 'triplet', 'ratio')
OPTIMIZERS = ('adamw', 'sgdr')
PRECISIONS = ('float32', 'bfloat16')
_LEAST = {
    'steps': 1, 'scenes_per_class': 2, 'num_points': 4, 'warm_restart_steps': 1,
    'lifted_clones': 0, 'headings': 1,
}  # fmt: skip


@dataclass(frozen=True)
class TrainingConfig:
    """Everything that a training run depends on besides its data.

    Attributes:
        encoder: name of the network.
        steps: optimiser steps.
        scenes_per_class: scenes of each relation in a batch.
        num_points: points an object, drawn anew for each use.
        loss: ``all_pairs``, ``neighbourhood``, ``multi_similarity``, ``triplet`` (the paper's)
            or ``ratio`` (the released code's); see :mod:`spatial_relations_ros.learning.losses`.
        optimizer: ``adamw`` with one warm-up and cosine decay, or ``sgdr`` (the paper's).
        learning_rate: its peak.
        weight_decay: decay of all weights.
        precision: ``float32``, or ``bfloat16`` for the convolutions where the device has it.
        warm_restart_steps: first period of SGDR, doubled at each restart.
        swap_channels: whether base and relative change places at random, as in the paper; a
            metric trained so does not know roles.
        translation_noise: standard deviation, as a share of the scene's extent.
        rotation_noise_rad: standard deviation of small rotations.
        point_noise: largest standard deviation of noise on each point, as a share of the scene's
            extent; each object draws its own.
        sparse_share: share of objects that keep only some of their points, down to a tenth.
        partial_share: share of objects seen from one side only, as a depth camera sees them.
        random_negatives: share of a batch that is added as scenes with their objects at random
            poses, which are unlike anything; triplets take them as negatives.
        graded_weight: weight of the term that makes distances within a relation follow how far
            the scenes' measures are apart. Zero leaves all scenes of a relation alike.
        graded_reach: distance at which scenes of a relation lie whose measures are a whole unit
            apart.
        lifted_clones: copies in a batch whose relative object is lifted, sunk or tilted, which
            should lie at a distance that grows with the change; gives the pose optimisation a
            slope to follow where no real scene lies. Zero for none.
        lifted_weight: weight of that term.
        headings: over how many headings of a scene the trained metric averages its embedding.
    """

    encoder: str = 'compact'
    steps: int = 2200
    scenes_per_class: int = 12
    num_points: int = 1024
    loss: str = 'all_pairs'
    optimizer: str = 'adamw'
    learning_rate: float = 2e-3
    weight_decay: float = 1e-3
    precision: str = 'float32'
    warm_restart_steps: int = 1500
    swap_channels: bool = False
    translation_noise: float = 0.004
    rotation_noise_rad: float = 0.02
    point_noise: float = 0.0
    sparse_share: float = 0.0
    partial_share: float = 0.0
    random_negatives: float = 0.0
    graded_weight: float = 0.0
    graded_reach: float = 0.4
    lifted_clones: int = 16
    lifted_weight: float = 0.5
    headings: int = 1

    def __post_init__(self) -> None:
        _one_of('loss', self.loss, LOSSES)
        _one_of('optimizer', self.optimizer, OPTIMIZERS)
        _one_of('precision', self.precision, PRECISIONS)
        for name, least in _LEAST.items():
            if getattr(self, name) < least:
                raise ConfigError(f'{name} is {getattr(self, name)}; at least {least} is needed')
        for item in dataclasses.fields(self):
            value = getattr(self, item.name)
            if isinstance(value, float) and not 0.0 <= value < math.inf:
                raise ConfigError(f'{item.name} is {value}; expected a finite number from 0 on')
        for name in ('sparse_share', 'partial_share', 'random_negatives'):
            if getattr(self, name) > 1.0:
                raise ConfigError(f'{name} is {getattr(self, name)}; a share lies in 0 to 1')


def _one_of(name: str, value: str, known: tuple[str, ...]) -> None:
    if value not in known:
        raise ConfigError(f'{name} is {value!r}; expected one of {", ".join(known)}')


_DEFAULT = TrainingConfig(
    steps=8000, loss='neighbourhood', point_noise=0.003, sparse_share=0.15, partial_share=0.12,
    graded_weight=0.3, headings=4, random_negatives=0.1,
)  # fmt: skip
_PAPER = TrainingConfig(
    encoder='jund2018', steps=14000, scenes_per_class=15, num_points=4096, loss='triplet',
    optimizer='sgdr', learning_rate=1e-3, weight_decay=5e-4, swap_channels=True, lifted_clones=0,
)  # fmt: skip

CONFIGS: dict[str, TrainingConfig] = {
    'default': _DEFAULT,
    # The paper's network with our loss and views; for GPUs.
    'jund2018': dataclasses.replace(
        _DEFAULT, encoder='jund2018', num_points=2048, learning_rate=7e-4
    ),
    'multi_similarity': dataclasses.replace(_DEFAULT, loss='multi_similarity'),
    'paper': _PAPER,
    'released': dataclasses.replace(
        _PAPER, encoder='jund2018_released', loss='ratio', random_negatives=0.2
    ),
}  # fmt: skip


def training_config(name: str) -> TrainingConfig:
    """A named configuration.

    Raises:
        ConfigError: for an unknown name.
    """
    if name not in CONFIGS:
        raise ConfigError(f'no configuration {name!r}; there are {", ".join(sorted(CONFIGS))}')
    return CONFIGS[name]


def parse_settings(settings: Iterable[str]) -> dict[str, Any]:
    """What ``NAME=VALUE`` texts set, as arguments of :func:`dataclasses.replace`.

    Args:
        settings: names of attributes of :class:`TrainingConfig` and their values; a switch is
            ``true`` or ``false``.

    Raises:
        ConfigError: for a text without ``=``, an unknown name or a value of another type.
    """
    types = {item.name: type(item.default) for item in dataclasses.fields(TrainingConfig)}
    values: dict[str, Any] = {}
    for setting in settings:
        name, equals, text = setting.partition('=')
        if not equals:
            raise ConfigError(f'{setting!r} sets nothing; expected NAME=VALUE, as in steps=100')
        if name not in types:
            raise ConfigError(f'training has no {name!r} to set; there are {", ".join(types)}')
        values[name] = _value(name, text, types[name])
    return values


def _value(name: str, text: str, kind: type) -> Any:
    if kind is bool:
        if text not in ('true', 'false'):
            raise ConfigError(f'{name} is {text!r}; expected true or false')
        return text == 'true'
    try:
        return kind(text)
    except ValueError as error:
        wanted = 'a whole number' if kind is int else 'a number'
        raise ConfigError(f'{name} is {text!r}; expected {wanted}') from error
