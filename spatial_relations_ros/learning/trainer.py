"""Training of the metric."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from spatial_relations_ros.core import (
    ConfigError,
    DatasetFormatError,
    TrainingError,
    WeightsError,
    atomic_write,
)
from spatial_relations_ros.learning.batch_loss import BatchLoss
from spatial_relations_ros.learning.distributed import Place, training_place
from spatial_relations_ros.learning.encoders import Encoder, make_encoder
from spatial_relations_ros.learning.training_config import TrainingConfig
from spatial_relations_ros.learning.training_set import TrainingSet

CHECKPOINT_SECONDS = 60.0
CHECKPOINT_NAME = 'checkpoint.pt'
_MAX_GRADIENT_NORM = 5.0
_WARM_UP_SHARE, _WARM_UP_SHARE_OF_TEN = 0.1, 0.2


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
    device: str = 'auto',
    on_progress: ProgressCallback | None = None,
) -> Encoder:
    """Trains an encoder from nothing, or goes on from the checkpoint in ``run_dir``.

    Under ``torchrun`` each process draws batches of its own and the gradients are averaged; all
    of them must see the same ``run_dir``.

    Args:
        training_set: labelled scenes.
        config: network, loss and schedule.
        seed: of weights, batches and augmentation. On one machine and thread count the result
            repeats exactly, also when the run is killed at any moment and resumed.
        run_dir: folder of ``checkpoint.pt`` and ``losses.csv``; None keeps nothing.
        device: ``auto``, ``cpu`` or ``cuda``.
        on_progress: called after each step, in the first process.

    Raises:
        WeightsError: when the checkpoint belongs to another configuration or to other data, or is
            damaged.
        DatasetFormatError: when all scenes show the same relation.
        ConfigError: for a device that is not there.
        TrainingError: when the loss or its gradient is no longer finite; the last checkpoint is
            from before.
    """
    if len(torch.unique(training_set.labels)) < 2:
        raise DatasetFormatError('all scenes show the same relation; two relations are needed')
    with training_place(device) as place:
        run = _Run(training_set, config, seed, place)
        checkpoint = None if run_dir is None else run_dir / CHECKPOINT_NAME
        if checkpoint is not None and checkpoint.is_file():
            run.restore(checkpoint)
        start = last_saved = time.monotonic()
        while run.step < config.steps:
            loss = run.advance()
            if not place.is_main:
                continue
            now = time.monotonic()
            if checkpoint is not None and (now - last_saved > CHECKPOINT_SECONDS or run.is_done):
                run.save(checkpoint)
                last_saved = now
            if on_progress is not None:
                on_progress(TrainingProgress(run.step, config.steps, loss, now - start))
        return run.encoder.cpu().eval()


class _Run:
    """State of one training run."""

    def __init__(
        self, training_set: TrainingSet, config: TrainingConfig, seed: int, place: Place
    ) -> None:
        torch.manual_seed(seed)
        self.config, self.seed, self.place = config, seed, place
        self.data_sha256 = training_set.sha256()
        self.training_set = training_set.to(place.device)
        self.encoder = make_encoder(config.encoder).to(place.device)
        self.encoder.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        self.batch_loss = BatchLoss(config).to(place.device)
        # What is called in training: the encoder, or its wrapper that averages gradients.
        self.model: nn.Module = self.encoder
        if place.is_shared:
            self.model = nn.parallel.DistributedDataParallel(self.encoder)
        self.optimizer, self.schedule = _optimizer(self.encoder, config)
        self.step = 0
        self.losses: list[float] = []

    @property
    def is_done(self) -> bool:
        return self.step >= self.config.steps

    def advance(self) -> float:
        """One optimiser step; returns its loss."""
        self.model.train()
        self.batch_loss.train()
        loss = self.batch_loss(self.training_set, self._embed, self._generator())
        self.optimizer.zero_grad(set_to_none=True)
        torch.autograd.backward(loss)
        norm = nn.utils.clip_grad_norm_(self.encoder.parameters(), _MAX_GRADIENT_NORM)
        value = float(loss.detach())
        if not (math.isfinite(value) and math.isfinite(norm)):
            raise TrainingError(
                f'step {self.step + 1}: the loss is {value}, its gradient {float(norm)}; a '
                f'smaller learning_rate than {self.config.learning_rate} may help'
            )
        self.optimizer.step()
        self.schedule.step()
        self.step += 1
        self.losses.append(value)
        return value

    def _embed(self, images: Tensor) -> Tensor:
        low = self.config.precision == 'bfloat16'
        with torch.autocast(self.place.device.type, torch.bfloat16, enabled=low):
            embeddings: Tensor = self.model(images)
        return embeddings.float()

    def _generator(self) -> torch.Generator:
        """A stream of random numbers of this step and process, so that none must be saved."""
        stream = np.random.SeedSequence([self.seed, self.place.rank, self.step])
        first, second = (int(number) for number in stream.generate_state(2))
        torch.manual_seed(second)  # dropout
        return torch.Generator().manual_seed(first)

    def save(self, path: Path) -> None:
        """Writes a checkpoint and the losses so far, atomically."""
        state = {
            **self._identity(),
            'step': self.step,
            'losses': self.losses,
            'encoder': self.encoder.state_dict(),
            'batch_loss': self.batch_loss.state_dict(),
            'optimizer': self.optimizer.state_dict(),
            'schedule': self.schedule.state_dict(),
        }
        with atomic_write(path) as temporary:
            torch.save(state, temporary)
        self._write_losses(path.with_name('losses.csv'))

    def _identity(self) -> dict[str, Any]:
        """What a run must share with the one that it goes on from."""
        return {
            'config': dataclasses.asdict(self.config),
            'seed': self.seed,
            'num_processes': self.place.num_processes,
            'data_sha256': self.data_sha256,
        }

    def _write_losses(self, path: Path) -> None:
        lines = [f'{step},{loss:.6f}' for step, loss in enumerate(self.losses, start=1)]
        with atomic_write(path) as temporary:
            temporary.write_text('\n'.join(['step,loss', *lines, '']))

    def restore(self, path: Path) -> None:
        """Goes on from a checkpoint of the same run: configuration, seed, processes and data."""
        try:
            # weights_only: no pickled code is run.
            state: dict[str, Any] = torch.load(
                path, weights_only=True, map_location=self.place.device
            )
        except Exception as error:
            raise WeightsError(f'checkpoint {path} cannot be read: {error}') from error
        other = [key for key, value in self._identity().items() if state.get(key) != value]
        if other:
            raise WeightsError(
                f'checkpoint {path} belongs to another run, which differs in {", ".join(other)}; '
                'remove it or choose another run folder'
            )
        self.step, self.losses = state['step'], list(state['losses'])
        for name in ('encoder', 'batch_loss', 'optimizer', 'schedule'):
            getattr(self, name).load_state_dict(state[name])
        if self.place.is_main:
            # A kill may have come between the two files, or have left half of one.
            self._write_losses(path.with_name('losses.csv'))
            for half in path.parent.glob(f'.{path.stem}.*{path.suffix}'):
                half.unlink(missing_ok=True)


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
    # A warm-up of exactly one step would divide by zero in the schedule.
    warm_up = _WARM_UP_SHARE if config.steps != 10 else _WARM_UP_SHARE_OF_TEN
    one_cycle = torch.optim.lr_scheduler.OneCycleLR(
        adamw, rate, total_steps=config.steps, pct_start=warm_up
    )
    return adamw, one_cycle
