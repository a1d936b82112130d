"""Replays of several bags, wherever they run."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from spatial_relations_ros.core import SpatialRelationsError
from spatial_relations_ros.evaluation.bag_reader import BagReader, BagTopics
from spatial_relations_ros.evaluation.executors import Executor
from spatial_relations_ros.evaluation.replay import ReplayOptions, ReplayReport, replay_bag
from spatial_relations_ros.learning import load_metric
from spatial_relations_ros.pipeline import LibraryModels, PerceptionConfig, Pipeline

OnProgress = Callable[[int, int], None]


@dataclass(frozen=True)
class ReplayJob:
    """All that the replay of one bag needs; it can be sent to another machine.

    Attributes:
        bag: the bag's folder or file.
        options: what is asked.
        topics: to read; found by their types by default.
        models: folder of object models; without it objects are taken from the clouds.
        world_frame: frame of results.
        weights: of the metric; those that ship by default.
    """

    bag: Path
    options: ReplayOptions = field(default_factory=ReplayOptions)
    topics: BagTopics | None = None
    models: Path | None = None
    world_frame: str = 'world'
    weights: Path | None = None


@dataclass(frozen=True)
class FailedReplay:
    """A bag that could not be replayed.

    Attributes:
        bag_name: the bag's own name.
        error: why not.
    """

    bag_name: str
    error: SpatialRelationsError


def run_job(job: ReplayJob, on_progress: OnProgress | None = None) -> ReplayReport:
    """Replays one bag.

    Args:
        job: what to replay.
        on_progress: called with (clouds done, clouds in all).

    Raises:
        SpatialRelationsError: as ``replay_bag`` does, or when models or weights cannot be used.
    """
    pipeline = Pipeline(
        PerceptionConfig(world_frame=job.world_frame),
        None if job.models is None else LibraryModels(job.models),
    )
    metric = None if job.options.reference_ids is None else load_metric(job.weights)
    with BagReader(job.bag, job.topics) as reader:
        num_clouds = reader.contents[reader.topics().points][1]

    def advance(frame_idx: int) -> None:
        if on_progress is not None:
            on_progress(frame_idx + 1, num_clouds)

    return replay_bag(
        job.bag,
        pipeline,
        metric,
        job.options,
        topics=job.topics,
        on_frame=lambda frame, _: advance(frame.frame_idx),
    )


def run_jobs(
    jobs: Sequence[ReplayJob], executor: Executor, on_progress: OnProgress | None = None
) -> Iterator[ReplayReport | FailedReplay]:
    """Replays bags, in the order given; one that cannot be replayed costs itself only.

    Args:
        jobs: what to replay.
        executor: where; it does not change the reports.
        on_progress: of clouds, for an executor of this process only.
    """
    return executor.map(partial(_attempt, on_progress=on_progress), jobs)


def _attempt(job: ReplayJob, on_progress: OnProgress | None) -> ReplayReport | FailedReplay:
    try:
        return run_job(job, on_progress)
    except SpatialRelationsError as error:
        return FailedReplay(job.bag.name, error)
