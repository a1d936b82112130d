"""What the page shows of the objects: how far each is believed, its shape and where it stands."""

from __future__ import annotations

import json
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from spatial_relations_ros.core import SceneObject
from spatial_relations_ros.perception.track_state import TrackState
from spatial_relations_ros.visualization.report import ModelStore, pose_content

NUM_TRIANGLES = 4000
MAX_MODELS = 128

States = Mapping[str, tuple[TrackState | None, str]]
"""By object id: how far its pose is believed, and words: the reason, or where it is from."""


class Shapes(ModelStore):
    """Shapes that pages ask for, the newest ones; clouds without a model change all the time."""

    def __init__(self) -> None:
        super().__init__(NUM_TRIANGLES)
        self._lock = threading.Lock()

    def add(self, item: SceneObject) -> str:
        """The key of the object's shape, which becomes the newest."""
        with self._lock:
            key = super().add(item)
            self.models[key] = self.models.pop(key)
            while len(self.models) > MAX_MODELS:
                del self.models[next(iter(self.models))]
        return key

    def text(self, key: str) -> str | None:
        """A shape as JSON text; None when it is not known or no longer."""
        with self._lock:
            model = self.models.get(key)
        return None if model is None else json.dumps(model, separators=(',', ':'))


@dataclass(frozen=True)
class _Place:
    model: str
    pose: list[float]


class SeenObjects:
    """The objects as the page lists them; those that are not seen now stay where they were.

    Args:
        shapes: gets what is to be drawn.
    """

    def __init__(self, shapes: Shapes) -> None:
        self._shapes = shapes
        self._places: dict[str, _Place] = {}

    def content(self, states: States, seen: Mapping[str, SceneObject]) -> list[dict[str, Any]]:
        """Objects in the order of their ids.

        Each has ``id``, ``state`` (empty when it has none), ``reason``, ``is_seen`` (whether a
        relation can be made with it now), and ``model`` and ``pose`` or null.
        """
        for object_id, item in seen.items():
            pose = pose_content(item.world_from_object)
            self._places[object_id] = _Place(self._shapes.add(item), pose)
        for object_id in self._places.keys() - states.keys() - seen.keys():
            del self._places[object_id]
        return [
            self._entry(object_id, *states.get(object_id, (TrackState.TRACKED, '')), seen)
            for object_id in sorted({*states, *seen})
        ]

    def _entry(
        self, object_id: str, state: TrackState | None, words: str, seen: Mapping[str, SceneObject]
    ) -> dict[str, Any]:
        place = self._places.get(object_id)
        return {
            'id': object_id,
            'state': '' if state is None else state.value,
            'reason': words,
            'is_seen': object_id in seen,
            'model': None if place is None else place.model,
            'pose': None if place is None else place.pose,
        }
