"""Named training configurations."""

from __future__ import annotations

from dataclasses import dataclass

from spatial_relations_ros.core import ConfigError


@dataclass(frozen=True)
class TrainingConfig:
    """Everything that a training run depends on besides its data.

    Attributes:
        encoder: name of the network.
        steps: optimiser steps.
        scenes_per_class: scenes of each relation in a batch.
        num_points: points an object, drawn anew for each use.
        loss: ``all_pairs`` or ``triplet`` (the paper's).
        optimizer: ``adamw`` with one warm-up and cosine decay, or ``sgdr`` (the paper's).
        learning_rate: its peak.
        weight_decay: decay of all weights.
        warm_restart_steps: first period of SGDR, doubled at each restart.
        swap_channels: whether base and relative change places at random, as in the paper; a
            metric trained so does not know roles.
        translation_noise: standard deviation, as a share of the scene's extent.
        rotation_noise_rad: standard deviation of small rotations.
        lifted_clones: copies in a batch whose relative object is lifted, sunk or tilted, which
            should lie at a distance that grows with the change; gives the pose optimisation a
            slope to follow where no real scene lies. Zero for none.
        lifted_weight: weight of that term.
    """

    encoder: str = 'compact'
    steps: int = 2200
    scenes_per_class: int = 12
    num_points: int = 1024
    loss: str = 'all_pairs'
    optimizer: str = 'adamw'
    learning_rate: float = 2e-3
    weight_decay: float = 1e-3
    warm_restart_steps: int = 1500
    swap_channels: bool = False
    translation_noise: float = 0.004
    rotation_noise_rad: float = 0.02
    lifted_clones: int = 16
    lifted_weight: float = 0.5

    def __post_init__(self) -> None:
        if self.loss not in ('all_pairs', 'triplet'):
            raise ConfigError(f'loss is {self.loss!r}; expected all_pairs or triplet')
        if self.optimizer not in ('adamw', 'sgdr'):
            raise ConfigError(f'optimizer is {self.optimizer!r}; expected adamw or sgdr')
        if self.steps < 1 or self.scenes_per_class < 2 or self.num_points < 4:
            raise ConfigError(
                f'steps {self.steps}, scenes_per_class {self.scenes_per_class}, num_points '
                f'{self.num_points}: at least 1, 2 and 4 are needed'
            )


CONFIGS: dict[str, TrainingConfig] = {
    'default': TrainingConfig(),
    'jund2018': TrainingConfig(
        encoder='jund2018', steps=400, scenes_per_class=5, num_points=2048, learning_rate=7e-4,
        lifted_clones=5,
    ),
    'paper': TrainingConfig(
        encoder='jund2018', steps=14000, scenes_per_class=15, num_points=4096, loss='triplet',
        optimizer='sgdr', learning_rate=1e-3, weight_decay=5e-4, swap_channels=True,
        lifted_clones=0,
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
