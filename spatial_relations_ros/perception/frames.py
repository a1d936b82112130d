"""Transforms between frames over time, as /tf and /tf_static give them."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pytransform3d.rotations import quaternion_slerp
from pytransform3d.transform_manager import TemporalTransformManager, TimeVaryingTransform

from spatial_relations_ros.core import ConfigError, FrameTransformError, Pose
from spatial_relations_ros.perception.border import StampedTransform
from spatial_relations_ros.perception.series import NS_PER_SEC, StampedSeries

MAX_FRAMES = 256
MAX_RECENT = 256


@dataclass(frozen=True)
class TransformBufferConfig:
    """Limits of the buffer.

    Attributes:
        history_sec: how long moving transforms are remembered.
        max_samples: how many samples of one moving transform are remembered.
        max_extrapolation_sec: how far outside its samples a moving transform is still believed;
            the nearest sample is held there.
        jump_back_sec: a step back in time by more than this is a restart of the clock: what one
            transform was before it is forgotten.
    """

    history_sec: float = 10.0
    max_samples: int = 2000
    max_extrapolation_sec: float = 0.1
    jump_back_sec: float = 1.0

    def __post_init__(self) -> None:
        if not (self.history_sec > 0 and self.max_samples >= 1 and self.jump_back_sec > 0):
            raise ConfigError(f'history, samples and jump must be positive, got {self}')
        if not self.max_extrapolation_sec >= 0:
            raise ConfigError(f'max_extrapolation_sec must not be negative, got {self}')


def interpolate_poses(first: Pose, second: Pose, fraction: float) -> Pose:
    """The pose between two: translation on the line, rotation on the shortest great arc.

    Args:
        first: the pose at fraction 0.
        second: the pose at fraction 1.
        fraction: 0 to 1.
    """
    quat_wxyz = quaternion_slerp(first.quat_wxyz, second.quat_wxyz, fraction, shortest_path=True)
    return Pose((1.0 - fraction) * first.translation + fraction * second.translation, quat_wxyz)


class _Edge(TimeVaryingTransform):  # type: ignore[misc]
    """One transform of the tree: static, or samples over time.

    Times are integers in nanoseconds: as floats they would be rounded to 256 ns.
    """

    def __init__(self, parent: str, child: str, config: TransformBufferConfig) -> None:
        self.parent, self.child = parent, child
        self.static_matrix: NDArray[np.float64] | None = None
        self._extrapolation_ns = round(config.max_extrapolation_sec * NS_PER_SEC)
        self.series: StampedSeries[Pose] = StampedSeries(
            history_ns=round(config.history_sec * NS_PER_SEC),
            max_samples=config.max_samples,
            jump_back_ns=round(config.jump_back_sec * NS_PER_SEC),
        )

    def as_matrix(self, query_time: int) -> NDArray[np.float64]:
        """parent_from_child (4, 4) at a time in nanoseconds."""
        if self.static_matrix is not None:
            return self.static_matrix
        before, after = self.series.around(query_time)
        if before and after:
            fraction = (query_time - before[0]) / (after[0] - before[0])
            return interpolate_poses(before[1], after[1], fraction).as_matrix()
        nearest = before or after
        if nearest is None:
            raise FrameTransformError(
                f'the transform from {self.child!r} to {self.parent!r} was forgotten when time '
                'jumped back and has not arrived since'
            )
        if abs(query_time - nearest[0]) > self._extrapolation_ns:
            raise FrameTransformError(
                f'no transform from {self.child!r} to {self.parent!r} at {_seconds(query_time)}: '
                f'known from {_seconds(self.series.oldest_ns)} to '
                f'{_seconds(self.series.newest_ns)}, and '
                f'{_seconds(self._extrapolation_ns)} beyond it'
            )
        return nearest[1].as_matrix()

    def check_transforms(self) -> _Edge:
        """Nothing to check: poses are valid by construction."""
        return self


class TransformBuffer:
    """Remembers transforms and chains them, for one tree of frames.

    Safe to use from several threads.
    """

    def __init__(self, config: TransformBufferConfig | None = None) -> None:
        self._config = config or TransformBufferConfig()
        self._lock = threading.Lock()
        self._edges: dict[str, _Edge] = {}
        self._manager: Any = TemporalTransformManager()
        # All objects of a frame ask for the same transform at the same time.
        self._recent: dict[tuple[str, str, int], Pose] = {}

    @property
    def frame_ids(self) -> tuple[str, ...]:
        """All frames that were named, sorted."""
        with self._lock:
            return tuple(sorted(self._manager.nodes))

    def add(self, transform: StampedTransform) -> None:
        """Stores a transform.

        A child that comes with another parent is moved to that parent.

        Raises:
            FrameTransformError: for an empty name, a frame that is its own parent, or more than
                ``MAX_FRAMES`` frames.
        """
        parent = clean_frame_id(transform.parent_frame)
        child = clean_frame_id(transform.child_frame)
        if not parent or not child or parent == child:
            raise FrameTransformError(
                f'a transform needs two different frames, got {child!r} in {parent!r}'
            )
        with self._lock:
            self._recent.clear()
            edge = self._edges.get(child)
            if edge is None or edge.parent != parent:
                edge = self._connect(parent, child)
            if transform.is_static:
                edge.static_matrix = transform.parent_from_child.as_matrix()
            else:
                edge.static_matrix = None
                edge.series.add(transform.stamp_ns, transform.parent_from_child)

    def lookup(self, target_frame: str, source_frame: str, stamp_ns: int) -> Pose:
        """``target_from_source`` at a time.

        Raises:
            FrameTransformError: when a frame is unknown, both are not connected, or a moving
                transform on the way is not known at that time.
        """
        target, source = clean_frame_id(target_frame), clean_frame_id(source_frame)
        if target == source:
            return Pose.identity()
        with self._lock:
            key = target, source, stamp_ns
            if key not in self._recent:
                if len(self._recent) >= MAX_RECENT:
                    self._recent.clear()
                self._recent[key] = self._chained(target, source, stamp_ns)
            return self._recent[key]

    def forget_moving(self) -> None:
        """Forgets all samples of moving transforms; static ones stay."""
        with self._lock:
            self._recent.clear()
            for edge in self._edges.values():
                edge.series.clear()

    def _chained(self, target: str, source: str, stamp_ns: int) -> Pose:
        for frame in (source, target):
            if not self._manager.has_frame(frame):
                known = ', '.join(sorted(self._manager.nodes)) or 'none'
                raise FrameTransformError(
                    f'no transform from {source!r} to {target!r}: nothing is known of '
                    f'{frame!r}; known frames: {known}'
                )
        try:
            matrix = self._manager.get_transform_at_time(source, target, stamp_ns)
        except KeyError as error:
            raise FrameTransformError(
                f'no transform from {source!r} to {target!r}: they are not connected; '
                f'{self._describe_tree()}'
            ) from error
        return Pose.from_matrix(matrix)

    def _connect(self, parent: str, child: str) -> _Edge:
        new = {parent, child} - set(self._manager.nodes)
        if len(self._manager.nodes) + len(new) > MAX_FRAMES:
            raise FrameTransformError(
                f'{child!r} in {parent!r} is dropped: {MAX_FRAMES} frames are known already'
            )
        old = self._edges.pop(child, None)
        if old is not None:
            self._manager.remove_transform(child, old.parent)
        edge = self._edges[child] = _Edge(parent, child, self._config)
        self._manager.add_transform(child, parent, edge)
        return edge

    def _describe_tree(self) -> str:
        edges = sorted((edge.parent, child) for child, edge in self._edges.items())
        return 'known: ' + ', '.join(f'{parent} -> {child}' for parent, child in edges)


def clean_frame_id(frame_id: str) -> str:
    """A frame name without the leading slash of old publishers."""
    return frame_id.removeprefix('/')


def _seconds(stamp_ns: int) -> str:
    return f'{stamp_ns / NS_PER_SEC:.3f} s'
