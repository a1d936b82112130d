"""A bag through the same steps as live: perception of each cloud, imitation where asked.

The report holds nothing that depends on the clock: the same bag, weights and options give the
same report on one machine. How long the steps took is kept apart. Clouds of objects are kept for
the frames of imitations only, so that long bags fit into memory.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from spatial_relations_ros.core import (
    BagError,
    ConfigError,
    InvalidSceneError,
    Scene,
    UnknownObjectError,
)
from spatial_relations_ros.evaluation.bag_reader import BagReader, BagTopics, DroppedMessage
from spatial_relations_ros.evaluation.demonstrations import Demonstration
from spatial_relations_ros.evaluation.replay_choice import FrameChoice, Request
from spatial_relations_ros.imitation import ImitationOptions, ImitationResult, imitate
from spatial_relations_ros.learning import RelationMetric
from spatial_relations_ros.perception.border import Frame, FrameResult
from spatial_relations_ros.perception.track_state import TrackStatus
from spatial_relations_ros.pipeline import Pipeline


@dataclass(frozen=True)
class ReplayOptions:
    """What is asked of a replay.

    Attributes:
        reference_ids: base and relative of the demonstration; None replays perception alone.
        test_ids: base and relative to place; needed with ``reference_ids``.
        every: the relation is imitated in every how many-th frame that shows all four objects,
            unless one of the following says where.
        frame_idxs: imitate in these frames of the bag.
        at_sec: imitate in the first frame that shows all four objects this long after the first
            cloud, seconds.
        demonstrations: imitate each demonstration that is found, once, in its first frame after
            it has held still that shows all four objects.
        imitation: settings of each imitation; the table that perception sees is filled in.

    Raises:
        ConfigError: for half a request, or a time budget, which would make results depend on
            the machine's load.
    """

    reference_ids: tuple[str, str] | None = None
    test_ids: tuple[str, str] | None = None
    every: int = 5
    frame_idxs: tuple[int, ...] = ()
    at_sec: tuple[float, ...] = ()
    demonstrations: bool = False
    imitation: ImitationOptions = field(default_factory=ImitationOptions)

    def __post_init__(self) -> None:
        if (self.reference_ids is None) != (self.test_ids is None):
            raise ConfigError('an imitation needs both reference and test ids, base and relative')
        if self.every < 1 or any(idx < 0 for idx in self.frame_idxs):
            raise ConfigError('every must be at least 1 and frames at least 0')
        if not all(math.isfinite(sec) and sec >= 0 for sec in self.at_sec):
            raise ConfigError(f'times must not be negative, got {self.at_sec}')
        if self.imitation.time_budget_sec:
            raise ConfigError('a replay has no time budget: its results must repeat')


@dataclass(frozen=True, eq=False)
class ReplayedFrame:
    """What became of one frame.

    Attributes:
        frame_idx: counted from 0 over the clouds that could be read.
        stamp_ns: of the cloud.
        object_ids: what was seen and believed, sorted.
        states: object id -> how far its tracked pose is believed.
        rejected: object id -> why it is not among them, in words.
        problem: why the whole frame cannot be used, or None.
        table_height: world z of the table, metres; None if none is seen.
        distance: between reference and test scene as they stand; None when either is not seen.
        reason: why they are not, in words; None otherwise.
        scenes: reference and test scene, where an imitation was made.
        imitation: where one was made.
        perception_sec: wall time.
        metric_sec: wall time of the distance.
    """

    frame_idx: int
    stamp_ns: int
    object_ids: tuple[str, ...]
    states: Mapping[str, TrackStatus]
    rejected: Mapping[str, str]
    problem: str | None
    table_height: float | None
    distance: float | None = None
    reason: str | None = None
    scenes: tuple[Scene, Scene] | None = None
    imitation: ImitationResult | None = None
    perception_sec: float = 0.0
    metric_sec: float = 0.0


OnFrame = Callable[[ReplayedFrame, FrameResult], None]


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
        demonstrations: of the reference relation, wherever it holds still.
        requests: for each of ``options.at_sec`` the frame in which it was imitated, or None.
    """

    bag_name: str
    topics: BagTopics
    model_hash: str | None
    options: ReplayOptions
    frames: tuple[ReplayedFrame, ...]
    dropped: tuple[DroppedMessage, ...]
    demonstrations: tuple[Demonstration, ...] = ()
    requests: tuple[Request, ...] = ()


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
        on_frame: called after each frame, with all that perception saw in it.

    Raises:
        BagError: when the bag cannot be read or holds no cloud that can be.
        ConfigError: when ids are given without a metric.
        ImitationError: when an imitation cannot be carried out.
    """
    options = options or ReplayOptions()
    if options.reference_ids is not None and metric is None:
        raise ConfigError('an imitation needs a metric')
    choice = FrameChoice(
        every=options.every,
        frame_idxs=options.frame_idxs,
        at_sec=options.at_sec,
        demonstrations=options.demonstrations,
    )
    with BagReader(path, topics) as reader:
        used_topics = reader.topics()
        frames = []
        for frame, result in _replay(reader.frames(), pipeline, metric, options, choice):
            frames.append(frame)
            if on_frame is not None:
                on_frame(frame, result)
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
        choice.demonstrations,
        choice.requests,
    )


def _replay(
    frames: Iterable[Frame],
    pipeline: Pipeline,
    metric: RelationMetric | None,
    options: ReplayOptions,
    choice: FrameChoice,
) -> Iterator[tuple[ReplayedFrame, FrameResult]]:
    for frame_idx, frame in enumerate(frames):
        start = time.perf_counter()
        result = pipeline.step(frame)
        perceived = time.perf_counter()
        replayed = _seen(frame_idx, result, perceived - start)
        if metric is not None and options.reference_ids is not None:
            assert options.test_ids is not None  # the options see to it
            reference = _scene_or_reason(result, options.reference_ids)
            test = _scene_or_reason(result, options.test_ids)
            replayed = _compared(replayed, reference, test, metric, options, choice)
        yield replayed, result


def _seen(frame_idx: int, result: FrameResult, perception_sec: float) -> ReplayedFrame:
    return ReplayedFrame(
        frame_idx,
        result.stamp_ns,
        tuple(sorted(result.objects)),
        dict(result.states),
        dict(result.rejected),
        result.problem,
        result.table_height,
        perception_sec=perception_sec,
    )


def _scene_or_reason(result: FrameResult, object_ids: tuple[str, str]) -> Scene | str:
    try:
        return result.scene(*object_ids)
    except (UnknownObjectError, InvalidSceneError) as error:
        return str(error)


def _compared(
    replayed: ReplayedFrame,
    reference: Scene | str,
    test: Scene | str,
    metric: RelationMetric,
    options: ReplayOptions,
    choice: FrameChoice,
) -> ReplayedFrame:
    """With the distance of both scenes, and the imitation where one is wanted."""
    shown = None if isinstance(reference, str) else reference
    is_whole = shown is not None and not isinstance(test, str)
    is_wanted = choice.is_wanted(replayed.frame_idx, replayed.stamp_ns, shown, is_whole=is_whole)
    for scene in (reference, test):
        if isinstance(scene, str):
            return dataclasses.replace(replayed, reason=scene)
    assert isinstance(reference, Scene)
    assert isinstance(test, Scene)
    start = time.perf_counter()
    distance = metric.distance(reference, test)
    metric_sec = time.perf_counter() - start
    compared = dataclasses.replace(replayed, distance=distance, metric_sec=metric_sec)
    if not is_wanted:
        return compared
    settings = options.imitation
    if settings.table_height is None:
        settings = dataclasses.replace(settings, table_height=replayed.table_height)
    imitation = imitate(metric, reference, test, settings)
    return dataclasses.replace(compared, scenes=(reference, test), imitation=imitation)
