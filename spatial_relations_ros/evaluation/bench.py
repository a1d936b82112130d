"""How long the steps take on this machine: medians and spread after a warm-up.

Scenes come from the project's own generator with a seed, so that two machines time the same work.
"""

from __future__ import annotations

import dataclasses
import os
import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from spatial_relations_ros.core import ConfigError, Scene
from spatial_relations_ros.datasets.freiburg import RelationDataset, load_dataset
from spatial_relations_ros.datasets.generator import generate_dataset
from spatial_relations_ros.evaluation.bag_reader import read_frames
from spatial_relations_ros.evaluation.reader_timing import kinect_message, structured_points
from spatial_relations_ros.evaluation.timings import MIN_RUNS, NUM_WARM_UPS, Timing
from spatial_relations_ros.evaluation.training import make_training_set
from spatial_relations_ros.imitation import ImitationOptions, imitate
from spatial_relations_ros.imitation.stages import STAGES
from spatial_relations_ros.learning import (
    ModelCard,
    RelationMetric,
    euclidean_distance,
    make_encoder,
)
from spatial_relations_ros.learning.encoders import Encoder
from spatial_relations_ros.learning.trainer import TrainingProgress, train_encoder
from spatial_relations_ros.learning.training_config import training_config
from spatial_relations_ros.perception.object_models import ModelSource
from spatial_relations_ros.perception.point_cloud2 import read_xyz
from spatial_relations_ros.pipeline import Pipeline

NUM_SCENES = 28
NUM_OBJECTS = 20
# Scenes, as imitation embeds them.
_BATCH = 8
# Every relation is imitated with the objects of a scene of another relation.
_PAPER_POINTS = 2000

OnRun = Callable[[int, int], None]


class Bench:
    """Times the steps.

    Args:
        metric: whose embedding and imitation are timed.
        runs: of each step after the warm-up.
        seed: of the scenes.

    Raises:
        ConfigError: for fewer than three runs.
    """

    def __init__(self, metric: RelationMetric, *, runs: int, seed: int = 0) -> None:
        if runs < MIN_RUNS:
            raise ConfigError(f'{runs} runs; at least {MIN_RUNS} tell a median')
        self.metric, self.runs = metric, runs
        self._dataset = _generated(seed)
        self._scenes = [self._dataset.scene_of(entry) for entry in self._dataset.scenes]

    def embed(self, on_run: OnRun | None = None) -> Timing:
        """The embedding of one scene."""
        return self._timed(
            'embed', lambda idx: self.metric.embed_scenes([self._scene(idx)]), on_run
        )

    def network_in_bfloat16(self, on_run: OnRun | None = None) -> list[Timing]:
        """The network on the images of eight scenes, with its layers in bfloat16 and as it is.

        Raises:
            ConfigError: on a processor without bfloat16 of its own, which would emulate it.
        """
        if not has_bfloat16():
            raise ConfigError('this processor has no bfloat16, which would be emulated')
        encoder = self.metric.encoder.for_inference()

        def low(images: Tensor) -> Tensor:
            with torch.autocast('cpu', torch.bfloat16):
                embeddings: Tensor = encoder(images)
            return embeddings

        names = 'network in bfloat16', 'network'
        return self._networks(names, low, encoder, on_run)

    def network_compiled(self, on_run: OnRun | None = None) -> list[Timing]:
        """The network on the images of eight scenes, compiled by PyTorch and as it is.

        The compilation, which takes place before, is not counted.

        Raises:
            ConfigError: without a C++ compiler.
        """
        compiler = os.environ.get('CXX', 'g++')
        if shutil.which(compiler) is None:
            raise ConfigError(f'{compiler} is not found; torch.compile needs a C++ compiler')
        encoder = self.metric.encoder.for_inference()
        names = 'network compiled', 'network not compiled'
        return self._networks(names, torch.compile(encoder), encoder, on_run)

    def _networks(
        self,
        names: tuple[str, str],
        changed: Callable[[Tensor], Tensor],
        encoder: Encoder,
        on_run: OnRun | None,
    ) -> list[Timing]:
        batch = np.stack([self.metric.projections(self._scene(idx)) for idx in range(_BATCH)])
        images = torch.from_numpy(batch)

        def step(network: Callable[[Tensor], Tensor]) -> None:
            with torch.no_grad():
                network(images)

        return [
            self._timed(names[0], lambda _: step(changed), on_run),
            self._timed(names[1], lambda _: step(encoder), on_run),
        ]

    def pose_gradient(self, on_run: OnRun | None = None) -> Timing:
        """From points to the distance of a scene and back to the points, the metric's network."""
        return self._gradient('pose gradient', self.metric, on_run)

    def pose_gradient_of_paper(self, on_run: OnRun | None = None) -> Timing:
        """The same with the paper's network; its weights are random, which costs the same."""
        return self._gradient('pose gradient of the paper', _paper_metric(), on_run)

    def _gradient(self, name: str, metric: RelationMetric, on_run: OnRun | None) -> Timing:
        reference = torch.zeros(metric.embedding_dim)

        def step(idx: int) -> None:
            points = torch.from_numpy(metric.scene_points(self._scene(idx)))[None]
            distance = euclidean_distance(metric.embed(points.requires_grad_(True)), reference)
            torch.autograd.backward(distance.sum())

        return self._timed(name, step, on_run)

    def imitate(self, on_run: OnRun | None = None) -> list[Timing]:
        """Imitations with the default options, their outcomes, parts, and those with new objects.

        Objects are paired blindly: about half of the requests cannot be met and are refused after
        a longer search.

        Each request is made twice: with objects that no request had before, measured apart, the
        first includes preparing their shapes.
        """
        parts: dict[str, list[float]] = {name: [] for name in STAGES}
        first: list[tuple[float, float]] = []
        successes: list[bool] = []
        seen: set[str] = set()

        def prepare(idx: int) -> None:
            ids = self._request(idx)[1].object_ids
            start = time.perf_counter(), time.process_time()
            imitate(self.metric, *self._request(idx), ImitationOptions())
            if idx and not seen.intersection(ids):
                first.append((time.perf_counter() - start[0], time.process_time() - start[1]))
            seen.update(ids)

        def step(idx: int) -> None:
            result = imitate(self.metric, *self._request(idx), ImitationOptions())
            successes.append(result.success)
            for name, seconds in result.stage_seconds.items():
                parts[name].append(seconds)

        whole = self._timed('imitate', step, on_run, before=prepare)
        split = [
            whole.where(f'imitate: {name}', [success is wanted for success in successes])
            for name, wanted in (('successes', True), ('refusals', False))
            if wanted in successes[NUM_WARM_UPS:]
        ]
        split += [
            Timing(f'imitate: {name}', tuple(seconds[NUM_WARM_UPS:]))
            for name, seconds in parts.items()
        ]
        if first:
            wall, cpu = zip(*first, strict=True)
            split.append(Timing('imitate: first request with two objects', wall, cpu))
        return [whole, *split]

    def imitate_as_paper(self, on_run: OnRun | None = None) -> Timing:
        """One imitation as the paper does it: its network, 600 steps of Adam, one start.

        The network's weights are random, which does not change how long it takes.
        """
        metric = _paper_metric()
        return self._timed(
            'imitate as the paper',
            lambda idx: imitate(metric, *self._request(idx), ImitationOptions.paper()),
            on_run,
        )

    def train_step(self, config_name: str = 'default', on_run: OnRun | None = None) -> Timing:
        """One step of training."""
        names = {entry.name for entry in self._dataset.scenes}
        training_set = make_training_set(self._dataset, names)
        total = NUM_WARM_UPS + self.runs
        config = dataclasses.replace(training_config(config_name), steps=total)
        stamps = [time.perf_counter()]

        def on_progress(progress: TrainingProgress) -> None:
            stamps.append(time.perf_counter())
            if on_run is not None:
                on_run(progress.step, total)

        train_encoder(training_set, config, seed=0, on_progress=on_progress)
        return Timing('train step', tuple(np.diff(stamps)[NUM_WARM_UPS:].tolist()))

    def perception(
        self, bag: Path, models: ModelSource | None = None, on_run: OnRun | None = None
    ) -> Timing:
        """One step of perception, over the frames of a bag again and again."""
        frames = list(read_frames(bag))
        if not frames:
            raise ConfigError(f'{bag} holds no cloud that can be used')
        pipeline = Pipeline(models=models)
        return self._timed(
            'perception', lambda idx: pipeline.step(frames[idx % len(frames)]), on_run
        )

    def reader(self, on_run: OnRun | None = None) -> Timing:
        """The finite points of a Kinect2's qhd message."""
        message = kinect_message()
        return self._timed('reader', lambda _: read_xyz(message).points, on_run)

    def structured_reader(self, on_run: OnRun | None = None) -> Timing:
        """The same by a structured array, as is usual."""
        message = kinect_message()
        return self._timed(
            'reader by structured array', lambda _: structured_points(message), on_run
        )

    def _scene(self, idx: int) -> Scene:
        return self._scenes[idx % len(self._scenes)]

    def _request(self, idx: int) -> tuple[Scene, Scene]:
        return self._scene(idx), self._scene(idx + 1)

    def _timed(
        self,
        name: str,
        step: Callable[[int], object],
        on_run: OnRun | None,
        *,
        before: Callable[[int], object] | None = None,
    ) -> Timing:
        seconds, cpu_seconds = [], []
        total = NUM_WARM_UPS + self.runs
        for idx in range(total):
            if before is not None:
                before(idx)
            start, cpu_start = time.perf_counter(), time.process_time()
            step(idx)
            seconds.append(time.perf_counter() - start)
            cpu_seconds.append(time.process_time() - cpu_start)
            if on_run is not None:
                on_run(idx + 1, total)
        return Timing(name, tuple(seconds[NUM_WARM_UPS:]), tuple(cpu_seconds[NUM_WARM_UPS:]))


def _paper_metric() -> RelationMetric:
    return RelationMetric(
        make_encoder('jund2018'), ModelCard('jund2018', num_points=_PAPER_POINTS)
    )


def use_threads(num_threads: int) -> None:
    """How many threads PyTorch computes with in this process."""
    torch.set_num_threads(num_threads)


def has_bfloat16() -> bool:
    """Whether the processor computes with bfloat16 itself."""
    capabilities = torch.cpu.get_capabilities()
    return any(capabilities.get(name) for name in ('avx512_bf16', 'amx_bf16', 'bf16'))


def _generated(seed: int) -> RelationDataset:
    with tempfile.TemporaryDirectory(prefix='relations_bench_') as folder:
        generate_dataset(folder, num_scenes=NUM_SCENES, num_objects=NUM_OBJECTS, seed=seed)
        return load_dataset(Path(folder))
