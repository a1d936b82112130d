"""Scenes of bodies at their poses."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import Scene, SceneObject
from spatial_relations_ros.placement.body import Placed
from spatial_relations_ros.placement.model import ObjectModel

NUM_POINTS = 8192

_clouds: WeakKeyDictionary[ObjectModel, NDArray[np.float32]] = WeakKeyDictionary()


def scene_of_placed(base: Placed, relative: Placed) -> Scene:
    """The scene of two bodies; ids are their models' names, told apart where they are the same."""
    names = [placed.body.model.name for placed in (base, relative)]
    if names[0] == names[1]:
        names = [f'{names[0]}_base', f'{names[1]}_relative']
    items = [
        SceneObject(name, _cloud(placed.body.model), placed.pose(), mesh=placed.body.model.mesh)
        for name, placed in zip(names, (base, relative), strict=True)
    ]
    return Scene(items[0], items[1])


def _cloud(model: ObjectModel) -> NDArray[np.float32]:
    """Points of a model, drawn once: scenes of the same object share them."""
    if model not in _clouds:
        _clouds[model] = model.points(NUM_POINTS, np.random.default_rng(0))
    return _clouds[model]
