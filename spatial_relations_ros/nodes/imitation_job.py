"""One imitation on the thread that models run on."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import CancelledError

from spatial_relations_ros.core import ImitationError, Scene
from spatial_relations_ros.evaluation.recorded_steps import StepRecorder, shown_as_it_ran
from spatial_relations_ros.imitation import (
    ImitationOptions,
    ImitationProgress,
    ImitationResult,
    imitate,
)
from spatial_relations_ros.nodes.model_host import ModelHost
from spatial_relations_ros.nodes.node_recording import NodeRecording
from spatial_relations_ros.visualization.recorded_imitation import record_imitation

POLL_SEC = 0.05


class ImitationJob:
    """One imitation; ``run`` is called on any other thread than the worker's."""

    def __init__(
        self,
        host: ModelHost,
        recording: NodeRecording,
        reference: Scene,
        test: Scene,
        options: ImitationOptions,
        is_cancelled: Callable[[], bool],
        on_progress: Callable[[ImitationProgress, Scene], None],
    ) -> None:
        self._host, self._recording = host, recording
        self._reference, self._test = reference, test
        self._steps = StepRecorder()
        self._options, self._is_cancelled, self._on_progress = options, is_cancelled, on_progress

    def run(self) -> ImitationResult:
        """Waits for the worker; a request that is cancelled in the queue never starts.

        Raises:
            ImitationError: when it was cancelled before it started.
        """
        future = self._host.worker.submit(self._work)
        while not future.done():
            if self._is_cancelled() and future.cancel():
                break
            try:
                return future.result(timeout=POLL_SEC)
            except TimeoutError:
                continue
        try:
            return future.result()
        except CancelledError:
            raise ImitationError('cancelled before it started') from None

    def _work(self) -> ImitationResult:
        metric = self._host.metric()
        result = imitate(
            metric,
            self._reference,
            self._test,
            self._options,
            on_progress=self._keep_going,
        )
        if self._recording.is_on:
            shown = shown_as_it_ran(
                self._reference, self._test, result, self._steps, self._options.table_height
            )
            self._recording.record(
                self._test.stamp_ns,
                lambda to: record_imitation(to, shown, projections=metric.projections),
            )
        return result

    def _keep_going(self, progress: ImitationProgress) -> bool:
        if self._recording.is_on:
            self._steps.record(progress)
        self._on_progress(progress, self._test)
        return not (self._is_cancelled() or self._host.worker.is_closing)
