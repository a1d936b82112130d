"""Training by several processes, one for each GPU or machine, started by ``torchrun``."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import torch
import torch.distributed
from torch import Tensor

from spatial_relations_ros.core import ConfigError


@dataclass(frozen=True)
class Place:
    """Where a process stands among those that train together.

    Attributes:
        rank: of the process; 0 reports and writes files.
        num_processes: in all.
        device: on which it computes.
    """

    rank: int
    num_processes: int
    device: torch.device

    @property
    def is_main(self) -> bool:
        """Whether this process reports and writes files."""
        return self.rank == 0

    @property
    def is_shared(self) -> bool:
        """Whether other processes train the same weights."""
        return self.num_processes > 1


def is_main_process() -> bool:
    """Whether this process is alone or the first of those that ``torchrun`` started."""
    return _num_processes() == 1 or int(os.environ.get('RANK', '0')) == 0


def mean_over_processes(value: Tensor) -> Tensor:
    """The mean of a tensor over all processes that train together; itself where there is one."""
    if not (torch.distributed.is_available() and torch.distributed.is_initialized()):
        return value
    value = value.clone()
    torch.distributed.all_reduce(value)
    return value / torch.distributed.get_world_size()


@contextmanager
def training_place(device: str = 'auto') -> Iterator[Place]:
    """Joins the processes that ``torchrun`` started, if it did, for as long as it is open.

    Args:
        device: ``auto`` (a GPU where there is one), ``cpu`` or ``cuda``.

    Raises:
        ConfigError: for a device that is not there.
    """
    num_processes = _num_processes()
    rank = int(os.environ.get('RANK', '0'))
    chosen = _device(device, int(os.environ.get('LOCAL_RANK', '0')))
    if num_processes == 1:
        yield Place(0, 1, chosen)
        return
    torch.distributed.init_process_group('nccl' if chosen.type == 'cuda' else 'gloo')
    try:
        yield Place(rank, num_processes, chosen)
    finally:
        torch.distributed.destroy_process_group()


def _num_processes() -> int:
    return int(os.environ.get('WORLD_SIZE', '1'))


def _device(name: str, local_rank: int) -> torch.device:
    if name not in ('auto', 'cpu', 'cuda'):
        raise ConfigError(f'device is {name!r}; expected auto, cpu or cuda')
    available = torch.cuda.is_available()
    if name == 'cuda' and not available:
        raise ConfigError('device is cuda, but PyTorch finds no GPU here; use auto or cpu')
    if name == 'cpu' or not available:
        return torch.device('cpu')
    torch.cuda.set_device(local_rank)
    return torch.device('cuda', local_rank)
