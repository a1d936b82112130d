"""Recordings for Rerun (https://rerun.io): scenes, projections and curves over time.

rerun-sdk is an optional dependency (extra ``viz``), imported when a recording is opened.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError, SceneObject
from spatial_relations_ros.visualization.images import Image
from spatial_relations_ros.visualization.palette import OBJECT_COLOURS, Rgb
from spatial_relations_ros.visualization.simplification import simplified_mesh
from spatial_relations_ros.visualization.surfaces import smooth_corner_normals

APPLICATION = 'spatial_relations_ros'
SPAWN = 'spawn'
MAX_TRIANGLES = 8000
POINT_RADIUS = 0.0015

Time = int | float


class Recording:
    """A stream of what happens, to a file or a viewer.

    Entities are named by a path of words; what is logged stands at the times that the same thread
    set last. Threads may share a recording when they log different entities.
    """

    def __init__(self, target: str, *, name: str = '') -> None:
        """Opens a recording.

        Args:
            target: a file ending with .rrd; ``spawn`` to start the viewer here; or the address
                of a running one, ``rerun+http://HOST:9876/proxy``.
            name: of the recording in the viewer.

        Raises:
            ConfigError: for another target, a folder that is absent, or without rerun-sdk.
        """
        check_target(target)
        rr = require_rerun()
        self._rr = rr
        self._stream = rr.RecordingStream(APPLICATION)
        if name:
            self._stream.send_recording_name(name)
        if target == SPAWN:
            self._stream.spawn()
        elif _is_address(target):
            self._stream.connect_grpc(target)
        else:
            self._stream.save(target)
        self._shapes: dict[tuple[str, ...], object] = {}
        self._stream.log('/', rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)

    def set_time(self, **times: Time) -> None:
        """Sets the place on timelines: an integer is a number of steps, a float seconds."""
        for timeline, value in times.items():
            if isinstance(value, int):
                self._stream.set_time(timeline, sequence=value)
            else:
                self._stream.set_time(timeline, duration=value)

    def log_objects(
        self,
        path: Sequence[str],
        objects: Iterable[SceneObject],
        *,
        colours: Sequence[Rgb] = OBJECT_COLOURS,
        alpha: float = 1.0,
    ) -> None:
        """Logs where objects are; their shapes only where they are new."""
        for idx, item in enumerate(objects):
            entity = (*path, item.object_id)
            shape: object = item.points if item.mesh is None else item.mesh
            if self._shapes.get(entity) is not shape:
                self._shapes[entity] = shape
                self._log(entity, self._shape(item, (*colours[idx % len(colours)], alpha)))
            quat_wxyz = item.world_from_object.quat_wxyz
            self._log(
                entity,
                self._rr.Transform3D(
                    translation=item.world_from_object.translation,
                    quaternion=np.roll(quat_wxyz, -1),
                ),
            )

    def log_image(self, path: Sequence[str], image: Image) -> None:
        """Logs a picture (H, W, 3) uint8 RGB."""
        self._log(path, self._rr.Image(image).compress(jpeg_quality=90))

    def log_number(self, path: Sequence[str], value: float) -> None:
        """Logs a point of a curve; NaN is left out."""
        if not math.isnan(value):
            self._log(path, self._rr.Scalars(float(value)))

    def log_text(self, path: Sequence[str], text: str, *, is_bad: bool = False) -> None:
        """Logs a line of text."""
        level = self._rr.TextLogLevel.WARN if is_bad else self._rr.TextLogLevel.INFO
        self._log(path, self._rr.TextLog(text, level=level))

    def flush(self) -> None:
        """Hands on everything that was logged."""
        self._stream.flush()

    def close(self) -> None:
        """Writes what waits and ends the recording."""
        self._stream.flush()
        self._stream.disconnect()

    def __enter__(self) -> Recording:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _log(self, path: Sequence[str], entity: Any) -> None:
        self._stream.log(list(path), entity)

    def _shape(self, item: SceneObject, colour: tuple[float, ...]) -> Any:
        if item.mesh is None:
            return self._rr.Points3D(item.points, radii=POINT_RADIUS, colors=[colour])
        mesh = simplified_mesh(item.mesh, MAX_TRIANGLES)
        normals: NDArray[np.float32] = smooth_corner_normals(mesh.vertices, mesh.triangles)
        return self._rr.Mesh3D(
            vertex_positions=mesh.vertices[mesh.triangles].reshape(-1, 3),
            vertex_normals=normals.reshape(-1, 3),
            albedo_factor=colour,
        )


def check_target(target: str) -> None:
    """Refuses a target before the work that could not be recorded after it.

    Raises:
        ConfigError: naming what would do.
    """
    if target == SPAWN or _is_address(target):
        return
    path = Path(target)
    if path.suffix != '.rrd':
        raise ConfigError(
            f'a recording goes to a file that ends with .rrd, to {SPAWN!r} (a viewer is started) '
            f'or to an address such as rerun+http://127.0.0.1:9876/proxy, got {target!r}'
        )
    if not path.absolute().parent.is_dir():
        raise ConfigError(f'the folder {path.absolute().parent} of the recording does not exist')


def _is_address(target: str) -> bool:
    return target.startswith(('rerun+http://', 'rerun+https://', 'rerun://'))


def require_rerun() -> Any:
    """The module ``rerun``.

    Raises:
        ConfigError: where it is not installed.
    """
    try:
        return importlib.import_module('rerun')
    except ImportError as error:
        raise ConfigError(
            f'recordings need rerun-sdk ({error}): pip install '
            "'rerun-sdk>=0.41,<0.42', which needs numpy 2"
        ) from error
