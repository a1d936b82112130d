"""Training of the metric."""

from __future__ import annotations

import csv
import dataclasses
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from spatial_relations_ros.core import ConfigError, WeightsError, atomic_write
from spatial_relations_ros.learning.encoders import Encoder, make_encoder
from spatial_relations_ros.learning.losses import (
    all_pairs_contrastive_loss,
    euclidean_distance,
    triplet_contrastive_loss,
)
from spatial_relations_ros.learning.training_config import TrainingConfig
from spatial_relations_ros.learning.training_set import TrainingSet, augment, lift_and_tilt
from spatial_relations_ros.projection import project

CHECKPOINT_SECONDS = 60.0


@dataclass(frozen=True)
class TrainingProgress:
    """Where a run stands: steps done and in all, the last loss, and seconds since the start."""

    step: int
    steps: int
    loss: float
    elapsed_sec: float


ProgressCallback = Callable[[TrainingProgress], None]


def train_encoder(
    training_set: TrainingSet,
    config: TrainingConfig,
    *,
    seed: int,
    run_dir: Path | None = None,
    on_progress: ProgressCallback | None = None,
) -> Encoder:
    """Trains an encoder from nothing, or goes on from the checkpoint in ``run_dir``.

    Args:
        training_set: labelled scenes.
        config: network, loss and schedule.
        seed: of weights, batches and augmentation. On one machine and thread count the result
            repeats exactly, also when the run is killed and resumed.
        run_dir: folder of ``checkpoint.pt`` and ``losses.csv``; None keeps nothing.
        on_progress: called after each step.

    Raises:
        WeightsError: when the checkpoint belongs to another configuration or is damaged.
    """
    run = _Run(training_set, config, seed)
    checkpoint = None if run_dir is None else run_dir / 'checkpoint.pt'
    if checkpoint is not None and checkpoint.is_file():
        run.restore(checkpoint)
    start = last_saved = time.monotonic()
    while run.step < config.steps:
        loss = run.advance()
        now = time.monotonic()
        if checkpoint is not None and (now - last_saved > CHECKPOINT_SECONDS or run.is_done):
            run.save(checkpoint)
            last_saved = now
        if on_progress is not None:
            on_progress(TrainingProgress(run.step, config.steps, loss, now - start))
    return run.encoder.eval()


class _Run:
    """State of one training run."""

    def __init__(self, training_set: TrainingSet, config: TrainingConfig, seed: int) -> None:
        torch.manual_seed(seed)
        self.training_set, self.config, self.seed = training_set, config, seed
        self.generator = torch.Generator().manual_seed(seed)
        self.encoder = make_encoder(config.encoder)
        self.encoder.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        self.optimizer, self.schedule = _optimizer(self.encoder, config)
        self.step = 0
        self.losses: list[float] = []

    @property
    def is_done(self) -> bool:
        return self.step >= self.config.steps

    def advance(self) -> float:
        """One optimiser step; returns its loss."""
        self.encoder.train()
        loss = self._loss()
        self.optimizer.zero_grad(set_to_none=True)
        torch.autograd.backward(loss)
        torch.nn.utils.clip_grad_norm_(self.encoder.parameters(), 5.0)
        self.optimizer.step()
        self.schedule.step()
        self.step += 1
        self.losses.append(float(loss.detach()))
        return self.losses[-1]

    def _loss(self) -> Tensor:
        config, generator = self.config, self.generator
        rows = self.training_set.draw_scenes(config.scenes_per_class, generator)
        points = self.training_set.points(rows, config.num_points, generator)
        batch = len(rows)
        clones = torch.randperm(batch, generator=generator)[: config.lifted_clones]
        lifted, change = lift_and_tilt(points[clones], generator)
        points = augment(torch.cat([points, lifted]), config, generator)
        embeddings = self.encoder(project(points, self.encoder.projection))
        loss = self._class_loss(embeddings[:batch], self.training_set.labels[rows])
        if len(clones):
            distances = euclidean_distance(embeddings[clones], embeddings[batch:])
            loss = loss + config.lifted_weight * (distances - change).square().mean()
        return loss

    def _class_loss(self, embeddings: Tensor, labels: Tensor) -> Tensor:
        if self.config.loss == 'all_pairs':
            return all_pairs_contrastive_loss(embeddings, labels)
        similar = labels[:, None] == labels[None, :]
        others = similar & ~torch.eye(len(labels), dtype=torch.bool)
        positive = torch.multinomial(others.float(), 1, generator=self.generator)[:, 0]
        negative = torch.multinomial((~similar).float(), 1, generator=self.generator)[:, 0]
        return triplet_contrastive_loss(embeddings, embeddings[positive], embeddings[negative])

    def save(self, path: Path) -> None:
        """Writes a checkpoint and the losses so far, atomically."""
        state = {
            'config': dataclasses.asdict(self.config),
            'seed': self.seed,
            'step': self.step,
            'losses': self.losses,
            'encoder': self.encoder.state_dict(),
            'optimizer': self.optimizer.state_dict(),
            'schedule': self.schedule.state_dict(),
            'generator': self.generator.get_state(),
            'dropout_generator': torch.get_rng_state(),
        }
        with atomic_write(path) as temporary:
            torch.save(state, temporary)
        with (
            atomic_write(path.with_name('losses.csv')) as temporary,
            open(temporary, 'w', newline='') as file,
        ):
            writer = csv.writer(file)
            writer.writerow(['step', 'loss'])
            writer.writerows((step + 1, f'{loss:.6f}') for step, loss in enumerate(self.losses))

    def restore(self, path: Path) -> None:
        """Goes on from a checkpoint of the same configuration and seed."""
        try:
            # weights_only: no pickled code is run.
            state: dict[str, Any] = torch.load(path, weights_only=True)
        except Exception as error:
            raise WeightsError(f'checkpoint {path} cannot be read: {error}') from error
        if state['config'] != dataclasses.asdict(self.config) or state['seed'] != self.seed:
            raise WeightsError(
                f'checkpoint {path} belongs to another configuration or seed; '
                'remove it or choose another run folder'
            )
        self.step, self.losses = state['step'], list(state['losses'])
        self.encoder.load_state_dict(state['encoder'])
        self.optimizer.load_state_dict(state['optimizer'])
        self.schedule.load_state_dict(state['schedule'])
        self.generator.set_state(state['generator'])
        torch.set_rng_state(state['dropout_generator'])


def _optimizer(
    encoder: Encoder, config: TrainingConfig
) -> tuple[torch.optim.Optimizer, torch.optim.lr_scheduler.LRScheduler]:
    parameters = list(encoder.parameters())
    rate, decay = config.learning_rate, config.weight_decay
    if config.optimizer == 'sgdr':
        sgd = torch.optim.SGD(parameters, lr=rate, momentum=0.9, weight_decay=decay)
        restarts = torch.optim.lr_scheduler.CosineAnnealingWarmRestarts(
            sgd, config.warm_restart_steps, T_mult=2
        )
        return sgd, restarts
    if config.optimizer != 'adamw':
        raise ConfigError(f'unknown optimizer {config.optimizer!r}')
    adamw = torch.optim.AdamW(parameters, lr=rate, weight_decay=decay)
    one_cycle = torch.optim.lr_scheduler.OneCycleLR(
        adamw, rate, total_steps=config.steps, pct_start=0.1
    )
    return adamw, one_cycle
