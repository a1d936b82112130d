"""Whether a placed pair is possible: overlaps, balance, a second of physics."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import Scene, SceneObject, TriangleMesh
from spatial_relations_ros.evaluation.judging import Measures
from spatial_relations_ros.placement.body import Body, Placed
from spatial_relations_ros.placement.convex_parts import ConvexPart
from spatial_relations_ros.placement.model import ObjectModel
from spatial_relations_ros.placement.physics import Motion, settle
from spatial_relations_ros.placement.stability import is_stable, resting_contacts

MAX_PENETRATION = 0.005
MAX_BELOW_TABLE = 0.005

PENETRATION = 'penetration'
BELOW_TABLE = 'below the table'
MOVED = 'moved in simulation'
NOT_IN_BALANCE = 'not in balance'


@dataclasses.dataclass(frozen=True)
class Feasibility:
    """What is known of a placement; nothing is held fixed, both objects may fall.

    Attributes:
        penetration: deepest point of one object in the other, metres.
        below_table: how far the lower one is below the table, metres.
        motions: of base and relative in one second of simulation; None where it was not asked
            for, or not run since an overlap has decided already.
        in_balance: whether contact forces with friction 0.5 hold both, on a level table and on
            such tilted by 4 degrees; stricter than the simulation about what touches what.
        simulated: whether the simulation was asked for.
    """

    penetration: float
    below_table: float
    motions: tuple[Motion, Motion] | None
    in_balance: bool
    simulated: bool

    @property
    def reasons(self) -> tuple[str, ...]:
        """Why it is not feasible; empty when it is.

        Without the simulation balance decides.
        """
        found = []
        if self.penetration > MAX_PENETRATION:
            found.append(PENETRATION)
        if self.below_table > MAX_BELOW_TABLE:
            found.append(BELOW_TABLE)
        if self.motions is not None and not all(motion.stayed for motion in self.motions):
            found.append(MOVED)
        if not self.simulated and not self.in_balance:
            found.append(NOT_IN_BALANCE)
        return tuple(found)

    @property
    def feasible(self) -> bool:
        """Whether there is no reason against it."""
        return not self.reasons


def require_simulation() -> None:
    """Fails before the work and not after it.

    Raises:
        ConfigError: where MuJoCo is not installed.
    """
    settle(())


def check_feasibility(
    scene: Scene, measures: Measures, densities: tuple[float, float], *, simulate: bool
) -> Feasibility:
    """Checks a scene on the table z = 0.

    Args:
        scene: with watertight meshes.
        measures: what the judge measured on it.
        densities: of base and relative, kg / m^3.
        simulate: let go for a second in MuJoCo, friction 0.8.

    Raises:
        ConfigError: where MuJoCo is not installed, or a mesh is not watertight.
    """
    base, relative = (
        _placed(item, density) for item, density in zip(scene.objects, densities, strict=True)
    )
    penetration = max(0.0, -measures.clearance)
    overlaps = penetration > MAX_PENETRATION or measures.penetration_of_table > MAX_BELOW_TABLE
    motions = None
    if simulate and not overlaps:
        first, second = settle((base, relative))
        motions = (first, second)
    in_balance = not overlaps and is_stable(base, relative, resting_contacts(base, relative))
    return Feasibility(penetration, measures.penetration_of_table, motions, in_balance, simulate)


_bodies: WeakKeyDictionary[TriangleMesh, tuple[Body, NDArray[np.float64]]] = WeakKeyDictionary()
_parts: WeakKeyDictionary[TriangleMesh, tuple[ConvexPart, ...]] = WeakKeyDictionary()


def remember_parts(mesh: TriangleMesh, parts: tuple[ConvexPart, ...]) -> None:
    """Takes convex parts of a mesh that are known already; cutting it takes seconds."""
    _parts[mesh] = parts


def remembered_parts(
    meshes: Iterable[TriangleMesh],
) -> list[tuple[TriangleMesh, tuple[ConvexPart, ...]]]:
    """Those of the meshes whose parts are known, each once, with their parts."""
    return [(mesh, _parts[mesh]) for mesh in dict.fromkeys(meshes) if mesh in _parts]


def _placed(item: SceneObject, density: float) -> Placed:
    """An object for contact queries and simulation, its frame moved to the middle of its box."""
    assert item.mesh is not None
    if item.mesh not in _bodies:
        _bodies[item.mesh] = _body(item.object_id, item.mesh, density)
    body, middle = _bodies[item.mesh]
    pose = item.world_from_object
    return Placed(body, pose.rotation, np.asarray(pose.apply(middle[None])[0]))


def _body(object_id: str, mesh: TriangleMesh, density: float) -> tuple[Body, NDArray[np.float64]]:
    """A body about the middle of a mesh's box, and that middle (3,) in the mesh's frame."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    middle = 0.5 * (low + high).astype(np.float64)
    centred = TriangleMesh((mesh.vertices - middle).astype(np.float32), mesh.triangles)
    name = re.sub(r'\W', '', object_id) or 'object'
    body = Body.of(ObjectModel(name, '', centred, {}, None, density))
    if mesh in _parts:
        # Where `cached_property` would keep them.
        body.__dict__['convex_parts'] = tuple(
            ConvexPart(part.points - middle, part.filled) for part in _parts[mesh]
        )
    return body, middle
