"""Where independent jobs run: in this process, in several, or on the machines of a Ray cluster."""

from __future__ import annotations

import importlib.util
import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any, Protocol, TypeVar

import torch

from spatial_relations_ros.core import ConfigError

Job = TypeVar('Job')
Result = TypeVar('Result')


class Executor(Protocol):
    """Runs jobs; which executor it is does not change what comes out.

    Jobs run on one PyTorch thread each: with more, sums come out in another order.
    """

    def map(self, function: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[Result]:
        """Results in the order of the jobs, each as soon as it and those before it are done.

        Args:
            function: of a module, so that other processes find it.
            jobs: that can be pickled, as their results can.
        """


class SerialExecutor:
    """One job after the other in this process."""

    def map(self, function: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[Result]:
        """See ``Executor``."""
        num_threads = torch.get_num_threads()
        for job in jobs:
            torch.set_num_threads(1)
            try:
                result = function(job)
            finally:
                torch.set_num_threads(num_threads)
            yield result


class ProcessExecutor:
    """Several processes on this machine.

    Args:
        num_processes: how many.
    """

    def __init__(self, num_processes: int) -> None:
        if num_processes < 1:
            raise ConfigError(f'asked for {num_processes} processes; at least one makes sense')
        self._num_processes = num_processes

    def map(self, function: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[Result]:
        """See ``Executor``."""
        # A fork would copy the locks of the thread pools of Open3D and of OpenMP.
        context = multiprocessing.get_context('spawn')
        with ProcessPoolExecutor(
            min(self._num_processes, len(jobs)) or 1,
            mp_context=context,
            initializer=torch.set_num_threads,
            initargs=(1,),
        ) as pool:
            try:
                yield from pool.map(function, jobs)
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                raise


class RayExecutor:
    """The machines of a Ray cluster.

    The package must be installed on each, and files must have the same paths there.

    Args:
        address: ``auto`` for the cluster that this machine is part of, ``host:port``, or
            ``local`` for one on this machine that ends with the work.

    Raises:
        ConfigError: when Ray is not installed, or there is no cluster.
    """

    def __init__(self, address: str) -> None:
        if importlib.util.find_spec('ray') is None:
            raise ConfigError(
                'Ray is not installed; on each machine: pip install "ray>=2.9" (extra `cluster`)'
            )
        self._address = address

    def map(self, function: Callable[[Job], Result], jobs: Sequence[Job]) -> Iterator[Result]:
        """See ``Executor``."""
        ray = importlib.import_module('ray')
        try:
            ray.init(address=self._address, log_to_driver=False, include_dashboard=False)
        except (ConnectionError, ValueError) as error:
            raise ConfigError(f'no Ray cluster at {self._address!r}: {error}') from error
        try:
            remote = ray.remote(num_cpus=1)(_on_one_thread)
            pending = [remote.remote(function, job) for job in jobs]
            for reference in pending:
                yield ray.get(reference)
        finally:
            ray.shutdown()


def _on_one_thread(function: Callable[[Any], Any], job: Any) -> Any:
    torch.set_num_threads(1)
    return function(job)
