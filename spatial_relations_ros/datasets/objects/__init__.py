"""Parametric household objects: watertight meshes with realistic sizes."""

from __future__ import annotations

import dataclasses

import numpy as np

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.datasets.objects.families import CONTAINERS, OTHERS
from spatial_relations_ros.placement.model import ObjectModel

__all__ = [
    'CONTAINER_FAMILIES',
    'OBJECT_FAMILIES',
    'sample_object',
]

_MAKERS = {**CONTAINERS, **OTHERS}

CONTAINER_FAMILIES: tuple[str, ...] = tuple(CONTAINERS)
OBJECT_FAMILIES: tuple[str, ...] = tuple(_MAKERS)


def sample_object(family: str, rng: np.random.Generator, *, name: str = '') -> ObjectModel:
    """Draws an object of a family, with dimensions from realistic ranges.

    Args:
        family: one of ``OBJECT_FAMILIES``.
        rng: source of the dimensions; the same state gives the same object.
        name: the object's name; the family when left out.

    Raises:
        ConfigError: for a family that does not exist.
    """
    try:
        maker = _MAKERS[family]
    except KeyError:
        raise ConfigError(
            f'no object family {family!r}; there are {", ".join(OBJECT_FAMILIES)}'
        ) from None
    return dataclasses.replace(maker(rng), name=name or family)
