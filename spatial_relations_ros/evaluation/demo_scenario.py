"""The table of the demonstration: two relations shown, and objects apart that can imitate them."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from spatial_relations_ros.core import Pose, Relation, SpatialRelationsError
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.datasets.kinect_simulator import Surface, look_at, table_mesh
from spatial_relations_ros.datasets.objects import sample_object
from spatial_relations_ros.placement.body import Body, Placed
from spatial_relations_ros.placement.contact import clearance
from spatial_relations_ros.placement.model import ObjectModel
from spatial_relations_ros.placement.resting import above, dropped
from spatial_relations_ros.placement.stability import is_stable, resting_contacts

TABLE_HEIGHT = 0.72
TABLE_SIZE = (0.80, 1.20)
CAMERA_POSITION = (-0.78, 0.0, TABLE_HEIGHT + 0.82)
CAMERA_TARGET = (0.0, 0.0, TABLE_HEIGHT)
TABLE_COLOUR = (150, 112, 74)
MAX_DRAWS = 100
MAX_FLOOR_GAP = 0.002
MAX_PENETRATION = 0.0005
MIN_INSIDE_DEPTH = 0.05
MIN_GAP = 0.02


@dataclass(frozen=True, eq=False)
class DemoObject:
    """An object of the demonstration at its true pose."""

    object_id: str
    model: ObjectModel
    world_from_object: Pose
    colour: tuple[int, int, int]

    def surface(self) -> Surface:
        """The object as the simulated sensor sees it."""
        return Surface(self.model.mesh.transformed(self.world_from_object), self.colour)


@dataclass(frozen=True)
class DemoImitation:
    """A demonstrated pair and the pair that is to imitate it, each (base, relative)."""

    relation: Relation
    reference_ids: tuple[str, str]
    test_ids: tuple[str, str]


IMITATIONS = (
    DemoImitation(Relation.ON_TOP, ('plate', 'cup'), ('tray', 'mug')),
    DemoImitation(Relation.INSIDE, ('pot', 'can'), ('basket', 'mug')),
)

# Where the pairs and the single objects stand: x away from the camera, y to its left.
_PLACES = {
    'plate': (0.15, 0.36),
    'pot': (0.12, 0.0),
    'basket': (0.10, -0.38),
    'tray': (-0.17, -0.22),
    'mug': (-0.19, 0.24),
}
_COLOURS = {
    'plate': (206, 208, 214),
    'cup': (196, 78, 62),
    'pot': (96, 104, 116),
    'can': (222, 178, 62),
    'basket': (78, 128, 92),
    'tray': (60, 96, 150),
    'mug': (228, 226, 216),
}


def make_scenario(seed: int) -> tuple[DemoObject, ...]:
    """Draws the objects and puts them on the table; the same seed gives the same table.

    The demonstrated pairs touch without penetration, and both test pairs are known to be able to
    imitate them: a placement in the same relation was found for each.

    Raises:
        SpatialRelationsError: when no objects are found that fit each other.
    """
    rng = np.random.default_rng(seed)
    mug = sample_object('mug', rng, name='mug')
    placed: dict[str, Placed] = {}
    for imitation in IMITATIONS:
        shown = _demonstration(imitation, rng)
        placed.update(zip(imitation.reference_ids, shown, strict=True))
        base_id = imitation.test_ids[0]
        base = _imitating_base(imitation.relation, base_id, mug, rng)
        placed[base_id] = _standing(base, rng)
    placed['mug'] = _standing(Body.of(mug), rng)
    pair_base = {item.reference_ids[1]: item.reference_ids[0] for item in IMITATIONS}
    for object_id, body in placed.items():
        x, y = _PLACES[pair_base.get(object_id, object_id)]
        placed[object_id] = body.moved(np.array([x, y, TABLE_HEIGHT]))
    _check_apart(placed, seed)
    return tuple(
        DemoObject(object_id, body.body.model, body.pose(), _COLOURS[object_id])
        for object_id, body in placed.items()
    )


def scenario_surfaces(objects: tuple[DemoObject, ...]) -> list[Surface]:
    """Table and objects as the simulated sensor sees them."""
    table = Surface(table_mesh(TABLE_SIZE, height=TABLE_HEIGHT), TABLE_COLOUR)
    return [table, *(item.surface() for item in objects)]


def world_from_camera() -> Pose:
    """Pose of the infrared camera's optical frame, on a mast before the table."""
    return look_at(CAMERA_POSITION, CAMERA_TARGET)


def _check_apart(placed: dict[str, Placed], seed: int) -> None:
    pairs = [item.reference_ids for item in IMITATIONS]
    for first, second in itertools.combinations(placed, 2):
        if (first, second) in pairs:
            continue
        gap = clearance(placed[first], placed[second])
        if gap < MIN_GAP:
            raise SpatialRelationsError(
                f'with seed {seed} {first} and {second} are {1000 * gap:.0f} mm apart; '
                f'another seed may give objects at least {1000 * MIN_GAP:.0f} mm apart'
            )


def _demonstration(imitation: DemoImitation, rng: np.random.Generator) -> tuple[Placed, Placed]:
    """The reference pair at rest in its relation, the base's origin at x = y = 0."""
    for _ in range(MAX_DRAWS):
        base, relative = (
            Body.of(sample_object(name, rng, name=name)) for name in imitation.reference_ids
        )
        pair = _stacked(imitation.relation, base, relative, rng)
        if pair is not None:
            return pair
    raise SpatialRelationsError(f'no {imitation.reference_ids} in {MAX_DRAWS} draws')


def _imitating_base(
    relation: Relation, family: str, relative: ObjectModel, rng: np.random.Generator
) -> Body:
    """A base that the relative object can stand in the relation to."""
    body = Body.of(relative)
    for _ in range(MAX_DRAWS):
        base = Body.of(sample_object(family, rng, name=family))
        if _stacked(relation, base, body, rng) is not None:
            return base
    raise SpatialRelationsError(f'no {family} for {relation.description} in {MAX_DRAWS} draws')


def _stacked(
    relation: Relation, base: Body, relative: Body, rng: np.random.Generator
) -> tuple[Placed, Placed] | None:
    """Lowers the relative upright on the base's floor; None when it does not rest there."""
    opening = base.model.opening
    if opening is None:
        return None
    fixed = _standing(base, rng)
    slack = 0.5 * (min(opening.floor_half_size) - max(relative.model.half_extents[:2]))
    offset = rng.uniform(-1.0, 1.0, 2) * max(slack, 0.0)
    centre = fixed.rotation @ [*(opening.centre + offset), 0.0]
    moving = dropped(above(_standing(relative, rng), fixed, centre), fixed)
    bottom = moving.translation[2] - relative.model.half_extents[2]
    floor = fixed.translation[2] + opening.floor_z
    rests = abs(bottom - floor) < MAX_FLOOR_GAP and clearance(fixed, moving) > -MAX_PENETRATION
    if not rests or not is_stable(fixed, moving, resting_contacts(fixed, moving)):
        return None
    reaches_out = bottom + 2.0 * relative.model.half_extents[2] > fixed.translation[2]
    is_deep = opening.depth > MIN_INSIDE_DEPTH
    return (fixed, moving) if is_deep == (relation is Relation.INSIDE) and reaches_out else None


def _standing(body: Body, rng: np.random.Generator) -> Placed:
    """Upright on z = 0 with any heading."""
    heading = matrix_from_rotvec(np.array([0.0, 0.0, rng.uniform(-np.pi, np.pi)]))
    return Placed(body, heading, np.zeros(3)).on_table()
