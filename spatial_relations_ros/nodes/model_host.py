"""Holds the metric for a process: loaded on the worker's thread, used there only."""

from __future__ import annotations

import contextlib
from collections.abc import Callable

import torch

from spatial_relations_ros.core import WeightsError
from spatial_relations_ros.learning import RelationMetric, load_metric
from spatial_relations_ros.ros.diagnostics import ERROR, OK, State
from spatial_relations_ros.ros.parameters import Parameters, ParameterSpec
from spatial_relations_ros.ros.waiting import Worker

MODEL_PARAMETERS = (
    ParameterSpec(
        'weights', '', 'Weights file (safetensors, its card beside it); empty: those shipped.'
    ),
    ParameterSpec(
        'num_threads',
        1,
        'Threads that PyTorch computes with; more make one request no faster. 0: as many as it '
        'finds.',
        minimum=0,
        maximum=256,
        is_fixed=True,
    ),
)


class ModelHost:
    """The metric of a node, or of several in one process.

    Args:
        worker: the thread that everything with the metric runs on.
        weights: asked for the path of the weights at each use, so that it can be changed live;
            empty takes the weights that ship with the package.
        num_threads: of PyTorch; 0 leaves its choice.
    """

    def __init__(self, worker: Worker, weights: Callable[[], str], *, num_threads: int = 0):
        self.worker = worker
        self._weights = weights
        self._num_threads = num_threads
        self._metric: RelationMetric | None = None
        self._loaded_from: str | None = None
        self._problem = ''

    @staticmethod
    def of_parameters(parameters: Parameters) -> ModelHost:
        """A host with its own worker, set by ``MODEL_PARAMETERS``."""
        return ModelHost(
            Worker(),
            lambda: parameters.text('weights'),
            num_threads=parameters.integer('num_threads'),
        )

    def load_early(self) -> None:
        """Loads in the background, so that the first request need not wait for it."""
        self.worker.submit(self._try_load)

    def metric(self) -> RelationMetric:
        """The metric; to be called on the worker's thread.

        Raises:
            WeightsError: when the weights cannot be used; the next call tries again.
        """
        path = self._weights()
        if self._metric is None or path != self._loaded_from:
            if self._num_threads:
                torch.set_num_threads(self._num_threads)
            try:
                self._metric = load_metric(path or None)
            except WeightsError as error:
                self._metric, self._problem = None, str(error)
                raise
            self._loaded_from, self._problem = path, ''
        return self._metric

    def forget(self) -> None:
        """Has the weights read again at the next use."""
        self._loaded_from = None

    def _try_load(self) -> None:
        # A problem is kept for diagnostics and said again to each request.
        with contextlib.suppress(WeightsError):
            self.metric()

    def state(self) -> State:
        """For diagnostics."""
        values: dict[str, object] = {
            'weights': self._weights() or 'shipped with the package',
            'pending_jobs': self.worker.num_pending,
        }
        if self._problem:
            return State(ERROR, self._problem, values)
        if self._metric is None:
            return State(OK, 'not loaded yet', values)
        values['sha256'] = self._metric.model_hash
        return State(OK, 'loaded', values)
