"""Drawing a scene of a wanted relation from a set of bodies."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from spatial_relations_ros.core import Relation, SpatialRelationsError
from spatial_relations_ros.datasets.generator.checks import Measured, measure
from spatial_relations_ros.placement.body import Body, Placed
from spatial_relations_ros.placement.inside import (
    place_inside,
    place_inside_lying,
)
from spatial_relations_ros.placement.leaning_on import (
    place_inclined,
    place_inside_inclined,
)
from spatial_relations_ros.placement.on import (
    place_next_to,
    place_on_edge,
    place_on_top,
)
from spatial_relations_ros.placement.resting import (
    BASE_WAYS,
    LEANING_WAYS,
    RELATIVE_WAYS,
    RELATIVE_WAYS_WHERE_BASE_LIES,
    SIDE_ONLY,
    UPRIGHT_ONLY,
    PlacingRule,
    Ways,
    about_z,
    rest_on_table,
)

MAX_ATTEMPTS = 3000
_FAVOURED_WEIGHT = 2
_FLAT_LEAST_HALF_WIDTH = 0.045
_TALL_LEAST_RATIO = 2.0

# How the base rests, how the relative does before it is placed, and how it is placed.
_PLACEMENTS: dict[Relation, tuple[Ways, Ways, PlacingRule]] = {
    Relation.ON_TOP: (BASE_WAYS, RELATIVE_WAYS, place_on_top),
    Relation.INSIDE: (UPRIGHT_ONLY, RELATIVE_WAYS, place_inside),
    Relation.NEXT_TO: (BASE_WAYS, RELATIVE_WAYS, place_next_to),
    Relation.INCLINED: (BASE_WAYS, LEANING_WAYS, place_inclined),
    Relation.ON_TOP_EDGE: (BASE_WAYS, RELATIVE_WAYS, place_on_edge),
    Relation.INSIDE_LYING: (SIDE_ONLY, RELATIVE_WAYS, place_inside_lying),
    Relation.INSIDE_INCLINED: (UPRIGHT_ONLY, LEANING_WAYS, place_inside_inclined),
}
_IN_CONTAINER = (Relation.INSIDE, Relation.INSIDE_LYING, Relation.INSIDE_INCLINED)


@dataclass(frozen=True, eq=False)
class GeneratedScene:
    """A scene and how many candidates were refused before it, by reason."""

    relation: Relation
    measured: Measured
    rejected: Counter[str] = field(default_factory=Counter)


class SceneSampler:
    """Draws scenes from a set of bodies."""

    def __init__(
        self, bodies: Sequence[Body], *, check: Callable[[Measured], str] | None = None
    ) -> None:
        """Takes the bodies that scenes are made of.

        Args:
            bodies: with distinct names.
            check: a last check of a measured scene; returns why it is refused, or nothing.
        """
        self._bodies = tuple(bodies)
        self._check = check
        self._pairs: dict[Relation, list[tuple[Body, list[Body]]]] = {}

    def sample(self, relation: Relation, rng: np.random.Generator) -> GeneratedScene:
        """Draws pairs and placements until one is at rest in the relation.

        The base's origin is at x = y = 0, the table at z = 0, the heading of the whole is random.

        Raises:
            SpatialRelationsError: when the bodies cannot be brought into the relation.
        """
        if relation not in self._pairs:
            self._pairs[relation] = _pairs(relation, self._bodies)
        pairs = self._pairs[relation]
        if not pairs:
            raise SpatialRelationsError(
                f'no two of {[body.model.name for body in self._bodies]} can be '
                f'{relation.description}'
            )
        rejected: Counter[str] = Counter()
        for _ in range(MAX_ATTEMPTS):
            base, relatives = pairs[int(rng.integers(len(pairs)))]
            relative = relatives[int(rng.integers(len(relatives)))]
            result = _attempt(relation, base, relative, rng)
            if isinstance(result, str):
                rejected[result] += 1
                continue
            refused = self._check(result) if self._check else ''
            if not refused:
                return GeneratedScene(relation, result, rejected)
            rejected[refused] += 1
        raise SpatialRelationsError(
            f'no scene {relation.description!r} in {MAX_ATTEMPTS} attempts; refused: '
            f'{dict(rejected)}'
        )


def sample_scene(
    relation: Relation, bodies: Sequence[Body], rng: np.random.Generator
) -> GeneratedScene:
    """One scene of a relation; see :meth:`SceneSampler.sample`."""
    return SceneSampler(bodies).sample(relation, rng)


def _attempt(
    relation: Relation, base: Body, relative: Body, rng: np.random.Generator
) -> Measured | str:
    """Places a pair; the measured scene, or why it is refused."""
    base_ways, relative_ways, rule = _PLACEMENTS[relation]
    fixed = rest_on_table(base, base_ways, rng)
    if fixed is None:
        return 'no rest pose'
    if relative_ways is RELATIVE_WAYS and base_ways is BASE_WAYS and _lies(fixed):
        relative_ways = RELATIVE_WAYS_WHERE_BASE_LIES
    standing = rest_on_table(relative, relative_ways, rng)
    if standing is None:
        return 'no rest pose'
    placed = rule(fixed, standing, rng)
    if isinstance(placed, str):
        return placed
    turn = about_z(rng.uniform(0.0, 2.0 * np.pi))
    shift = -turn @ fixed.translation * [1.0, 1.0, 0.0]
    base_placed, relative_placed = (body.turned(turn).moved(shift) for body in (fixed, placed))
    return measure(relation, base_placed, relative_placed)


def _lies(placed: Placed) -> bool:
    """Whether a body's upright axis is nearer to level than to up or down."""
    return bool(abs(placed.rotation[2, 2]) < np.sqrt(0.5))


def _pairs(relation: Relation, bodies: Sequence[Body]) -> list[tuple[Body, list[Body]]]:
    """Bases with the relatives that come into question by their sizes."""
    pairs = []
    for base in bodies:
        relatives = [
            body
            for body in bodies
            if body is not base and (relation not in _IN_CONTAINER or _could_hold(base, body))
        ]
        if relatives:
            is_favoured = relation not in _IN_CONTAINER and (_is_flat(base) or _is_tall(base))
            pairs += [(base, relatives)] * (_FAVOURED_WEIGHT if is_favoured else 1)
    return pairs


def _is_flat(body: Body) -> bool:
    """Plates, lids, trays, boards, books: people like to put things on them."""
    lengths = np.sort(body.model.half_extents)
    return bool(lengths[0] < 0.25 * lengths[1] and lengths[1] > _FLAT_LEAST_HALF_WIDTH)


def _is_tall(body: Body) -> bool:
    """Bottles and sprays, on whose small tops things rarely come to stand by chance."""
    width, height = body.model.half_extents[:2].max(), body.model.half_extents[2]
    return bool(height > _TALL_LEAST_RATIO * width)


def _could_hold(base: Body, relative: Body) -> bool:
    """Whether a relative's smallest section is smaller than a container's opening."""
    opening = base.model.opening
    if opening is None or not base.model.is_container:
        return False
    section = np.sort(relative.model.half_extents)[:2]
    return bool((section < np.sort(opening.rim_half_size)).all())
