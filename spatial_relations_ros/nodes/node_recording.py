"""What a node records for Rerun, when its parameter ``rerun`` says where to."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.perception.border import FrameResult
from spatial_relations_ros.perception.series import NS_PER_SEC
from spatial_relations_ros.ros.parameters import ParameterSpec
from spatial_relations_ros.ros.relations_node import RelationsNode

if TYPE_CHECKING:
    from spatial_relations_ros.visualization.recordings import Recording

RERUN = ParameterSpec(
    'rerun',
    '',
    'Record for Rerun: an .rrd file (one a process), spawn, or address of a viewer; empty: no.',
    is_fixed=True,
)


class _Shared:
    """Recordings of this process by their target: nodes of one process share a file."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._open: dict[str, tuple[Recording, int]] = {}

    def open(self, target: str, name: str) -> Recording:
        # Few nodes record; the others start sooner without the room of pictures.
        from spatial_relations_ros.visualization.recordings import Recording

        with self._lock:
            recording, users = self._open.get(target) or (Recording(target, name=name), 0)
            self._open[target] = recording, users + 1
            return recording

    def close(self, target: str) -> None:
        with self._lock:
            recording, users = self._open.pop(target)
            if users > 1:
                self._open[target] = recording, users - 1
            else:
                recording.close()


_shared = _Shared()


class NodeRecording:
    """A recording that never ends its node: what goes wrong is reported and it is closed.

    All calls come from one thread.
    """

    def __init__(self, node: RelationsNode) -> None:
        """Opens what the parameter ``rerun`` of the node names.

        Raises:
            ConfigError: when it cannot be opened.
        """
        self._target = target = node.parameters.text('rerun')
        self._node = node
        self._recording: Recording | None = None
        if target:
            try:
                self._recording = _shared.open(target, node.get_fully_qualified_name())
            except (OSError, RuntimeError) as error:
                raise ConfigError(f'rerun is {target!r}: {error}') from error

    @property
    def is_on(self) -> bool:
        """Whether anything is recorded."""
        return self._recording is not None

    def record(self, stamp_ns: int, log: Callable[[Recording], None]) -> None:
        """Lets ``log`` write at a time of the clouds."""
        if self._recording is None:
            return
        try:
            self._recording.set_time(stamp=stamp_ns / NS_PER_SEC)
            log(self._recording)
            self._recording.flush()
        except Exception as error:  # no picture is worth the node
            self._node.report_bad('rerun', error)

    def close(self) -> None:
        """Writes what waits."""
        if self._recording is not None:
            self._recording = None
            _shared.close(self._target)


def log_frame(recording: Recording, result: FrameResult) -> None:
    """Logs the objects of a frame, and why others are not among them."""
    recording.log_objects(('objects',), result.objects.values())
    for object_id, reason in _problems(result):
        recording.log_text(('log', object_id), reason, is_bad=True)


def _problems(result: FrameResult) -> Iterable[tuple[str, str]]:
    if result.problem is not None:
        return [('frame', result.problem)]
    return result.rejected.items()
