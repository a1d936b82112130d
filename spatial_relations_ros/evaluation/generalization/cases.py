"""What is imitated in an experiment."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from spatial_relations_ros.core import Pose, Relation, Scene, SceneObject

BOTH = ('base', 'relative')
DENSITY = 1000.0


@dataclass(frozen=True, eq=False)
class Case:
    """A demonstration, and the objects that shall imitate it; the table is at z = 0.

    Attributes:
        number: within its experiment, from 0.
        experiment: its name.
        relation: that is demonstrated, and so expected of the imitation.
        reference, test: scenes with watertight meshes, on the table.
        reference_name, test_name: of the scenes.
        movable: which test objects may move.
        densities: of base and relative of the test scene, kg / m^3.
    """

    number: int
    experiment: str
    relation: Relation
    reference: Scene
    test: Scene
    reference_name: str
    test_name: str
    movable: tuple[str, ...] = BOTH
    densities: tuple[float, float] = (DENSITY, DENSITY)


@dataclass(frozen=True, eq=False)
class Experiment:
    """A list of cases.

    Attributes:
        name: of the experiment.
        cases: numbered from 0.
        description: what is imitated with what, in a sentence.
        references: names of the demonstrated scenes with their relations; empty where each case
            has its own.
        left_out: how many pairs were left out, by reason.
    """

    name: str
    cases: tuple[Case, ...]
    description: str
    references: tuple[tuple[str, Relation], ...] = ()
    left_out: Counter[str] = field(default_factory=Counter)

    def thinned(self, at_most: int | None) -> Experiment:
        """At most so many cases, evenly over all; they keep their numbers."""
        if at_most is None or len(self.cases) <= at_most:
            return self
        chosen = np.linspace(0, len(self.cases) - 1, at_most).round().astype(int)
        return replace(self, cases=tuple(self.cases[idx] for idx in chosen))

    def entry(self) -> dict[str, Any]:
        """As it stands in JSON."""
        return {
            'name': self.name,
            'description': self.description,
            'cases': len(self.cases),
            'references': {name: relation.name.lower() for name, relation in self.references},
            'left_out': dict(self.left_out),
        }


def on_table(scene: Scene) -> Scene:
    """The scene moved vertically so that its lowest point lies on the table z = 0."""
    lowest = min(lowest_point(item) for item in scene.objects)
    lift = np.array([0.0, 0.0, -lowest])
    base, relative = (
        Pose(item.world_from_object.translation + lift, item.world_from_object.quat_wxyz)
        for item in scene.objects
    )
    return scene.with_poses(base, relative)


def lowest_point(item: SceneObject) -> float:
    """Height of an object's lowest vertex, or point where it has no mesh, metres."""
    points = item.points if item.mesh is None else item.mesh.vertices
    return float(item.world_from_object.apply(points)[:, 2].min())
