"""A bag through the same steps as live: perception of each cloud, imitation where asked.

The report holds nothing that depends on the clock: the same bag, weights and options give the
same report on one machine. How long the steps took is kept apart.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

from spatial_relations_ros.core import BagError, ConfigError, Scene, SpatialRelationsError
from spatial_relations_ros.evaluation.bag_reader import BagReader, BagTopics, DroppedMessage
from spatial_relations_ros.imitation import ImitationOptions, ImitationResult, imitate
from spatial_relations_ros.learning import RelationMetric
from spatial_relations_ros.perception.border import Frame, FrameResult
from spatial_relations_ros.pipeline import Pipeline

OnFrame = Callable[['ReplayedFrame'], None]


@dataclass(frozen=True)
class ReplayOptions:
    """What is asked of a replay.

    Attributes:
        reference_ids: base and relative of the demonstration; None replays perception alone.
        test_ids: base and relative to place; needed with ``reference_ids``.
        every: the relation is imitated in every how many-th frame that shows all four objects.
        frame_idxs: imitate in these frames of the bag instead; empty for ``every``.
        imitation: settings of each imitation; the table that perception sees is filled in.

    Raises:
        ConfigError: for half a request, or a time budget, which would make results depend on
            the machine's load.
    """

    reference_ids: tuple[str, str] | None = None
    test_ids: tuple[str, str] | None = None
    every: int = 5
    frame_idxs: tuple[int, ...] = ()
    imitation: ImitationOptions = field(default_factory=ImitationOptions)

    def __post_init__(self) -> None:
        if (self.reference_ids is None) != (self.test_ids is None):
            raise ConfigError('an imitation needs both reference and test ids, base and relative')
        if self.every < 1 or any(idx < 0 for idx in self.frame_idxs):
            raise ConfigError('every must be at least 1 and frames at least 0')
        if self.imitation.time_budget_sec:
            raise ConfigError('a replay has no time budget: its results must repeat')


@dataclass(frozen=True, eq=False)
class ReplayedFrame:
    """What became of one frame.

    Attributes:
        frame_idx: counted from 0 over the clouds that could be read.
        result: of perception.
        distance: between reference and test scene as they stand; None when either is not seen.
        reason: why they are not, in words; None otherwise.
        imitation: where one was made.
        perception_sec: wall time.
        metric_sec: wall time of the distance.
    """

    frame_idx: int
    result: FrameResult
    distance: float | None = None
    reason: str | None = None
    imitation: ImitationResult | None = None
    perception_sec: float = 0.0
    metric_sec: float = 0.0


@dataclass(frozen=True, eq=False)
class ReplayReport:
    """Outcome of a replay.

    Attributes:
        bag_name: the bag's own name, without its folder.
        topics: that were read.
        model_hash: of the metric; None without imitation.
        options: as asked.
        frames: one for each cloud that could be read.
        dropped: messages that could not be used, with reasons.
    """

    bag_name: str
    topics: BagTopics
    model_hash: str | None
    options: ReplayOptions
    frames: tuple[ReplayedFrame, ...]
    dropped: tuple[DroppedMessage, ...]


def replay_bag(
    path: Path | str,
    pipeline: Pipeline,
    metric: RelationMetric | None = None,
    options: ReplayOptions | None = None,
    *,
    topics: BagTopics | None = None,
    on_frame: OnFrame | None = None,
) -> ReplayReport:
    """Replays a bag.

    Args:
        path: the bag.
        pipeline: as a live node makes it; fresh, or results depend on what it has seen.
        metric: needed when ids are given.
        options: what to do; perception alone by default.
        topics: to read; found by their types by default.
        on_frame: called after each frame.

    Raises:
        BagError: when the bag cannot be read or holds no cloud that can be.
        ConfigError: when ids are given without a metric.
        ImitationError: when an imitation cannot be carried out.
    """
    options = options or ReplayOptions()
    if options.reference_ids is not None and metric is None:
        raise ConfigError('an imitation needs a metric')
    with BagReader(path, topics) as reader:
        used_topics = reader.topics()
        frames = []
        for frame in _replay(reader.frames(), pipeline, metric, options):
            frames.append(frame)
            if on_frame is not None:
                on_frame(frame)
        dropped = tuple(reader.dropped)
    if not frames:
        reasons = '; '.join(sorted({item.reason for item in dropped})[:3])
        raise BagError(
            f'no cloud on {used_topics.points} of {path} can be used: '
            + (reasons or 'the topic is empty')
        )
    return ReplayReport(
        Path(path).name,
        used_topics,
        None if options.reference_ids is None or metric is None else metric.model_hash,
        options,
        tuple(frames),
        dropped,
    )


def _replay(
    frames: Iterable[Frame],
    pipeline: Pipeline,
    metric: RelationMetric | None,
    options: ReplayOptions,
) -> Iterable[ReplayedFrame]:
    num_usable = 0
    for frame_idx, frame in enumerate(frames):
        start = time.perf_counter()
        result = pipeline.step(frame)
        perceived = time.perf_counter()
        replayed = ReplayedFrame(frame_idx, result, perception_sec=perceived - start)
        if options.reference_ids is None or options.test_ids is None or metric is None:
            yield replayed
            continue
        try:
            reference = pipeline.scene(*options.reference_ids)
            test = pipeline.scene(*options.test_ids)
        except SpatialRelationsError as error:
            yield dataclasses.replace(replayed, reason=str(error))
            continue
        wanted = (
            frame_idx in options.frame_idxs
            if options.frame_idxs
            else num_usable % options.every == 0
        )
        num_usable += 1
        distance = metric.distance(reference, test)
        yield dataclasses.replace(
            replayed,
            distance=distance,
            metric_sec=time.perf_counter() - perceived,
            imitation=_imitated(metric, reference, test, result, options) if wanted else None,
        )


def _imitated(
    metric: RelationMetric,
    reference: Scene,
    test: Scene,
    result: FrameResult,
    options: ReplayOptions,
) -> ImitationResult:
    settings = options.imitation
    if settings.table_height is None:
        settings = dataclasses.replace(settings, table_height=result.table_height)
    return imitate(metric, reference, test, settings)
