"""Chooses the frames of a replay in which a relation is imitated."""

from __future__ import annotations

from dataclasses import dataclass

from spatial_relations_ros.core import Scene
from spatial_relations_ros.evaluation.demonstrations import (
    Demonstration,
    DemonstrationFinder,
    RelationSample,
)
from spatial_relations_ros.perception.series import NS_PER_SEC


@dataclass(frozen=True)
class Request:
    """A time that was asked for.

    Attributes:
        at_sec: seconds after the first cloud.
        frame_idx: where it was imitated; None when no later frame shows all objects.
    """

    at_sec: float
    frame_idx: int | None = None


class FrameChoice:
    """Says of each frame in turn whether it is one.

    Args:
        every: every how many-th frame that shows everything, when nothing else is given.
        frame_idxs: these frames.
        at_sec: the first frame that shows everything after each of these times.
        demonstrations: one frame of each demonstration.
    """

    def __init__(
        self,
        *,
        every: int,
        frame_idxs: tuple[int, ...] = (),
        at_sec: tuple[float, ...] = (),
        demonstrations: bool = False,
    ) -> None:
        self._every = every
        self._frame_idxs = frozenset(frame_idxs)
        self._requests = [Request(sec) for sec in at_sec]
        self._uses_demonstrations = demonstrations
        self._finder = DemonstrationFinder()
        self._imitated: set[int] = set()
        self._first_ns: int | None = None
        self._num_whole = 0

    @property
    def demonstrations(self) -> tuple[Demonstration, ...]:
        """Those of the relation that was seen, whether asked for or not."""
        return self._finder.found

    @property
    def requests(self) -> tuple[Request, ...]:
        """What became of each time, in the order given."""
        return tuple(self._requests)

    def is_wanted(
        self, frame_idx: int, stamp_ns: int, reference: Scene | None, *, is_whole: bool
    ) -> bool:
        """To be asked of each frame in order.

        Args:
            frame_idx: of the frame.
            stamp_ns: its time.
            reference: the scene of the demonstration; None when it is not seen.
            is_whole: whether all objects are seen.
        """
        if self._first_ns is None:
            self._first_ns = stamp_ns
        demonstration = self._finder.add(_sample(frame_idx, stamp_ns, reference))
        if not is_whole:
            return False
        self._num_whole += 1
        is_wanted = frame_idx in self._frame_idxs
        for idx, request in enumerate(self._requests):
            elapsed_sec = (stamp_ns - self._first_ns) / NS_PER_SEC
            if request.frame_idx is None and elapsed_sec >= request.at_sec:
                self._requests[idx] = Request(request.at_sec, frame_idx)
                is_wanted = True
        if self._uses_demonstrations:
            if demonstration is not None and demonstration.first_frame not in self._imitated:
                self._imitated.add(demonstration.first_frame)
                is_wanted = True
        elif not self._frame_idxs and not self._requests:
            is_wanted = (self._num_whole - 1) % self._every == 0
        return is_wanted


def _sample(frame_idx: int, stamp_ns: int, reference: Scene | None) -> RelationSample:
    if reference is None:
        return RelationSample(frame_idx, stamp_ns, None)
    world_from_base = reference.base.world_from_object
    pose = world_from_base.inverse() @ reference.relative.world_from_object
    return RelationSample(frame_idx, stamp_ns, pose)
