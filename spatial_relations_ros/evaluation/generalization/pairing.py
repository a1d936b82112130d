"""Demonstrations paired with the objects that are to imitate them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from spatial_relations_ros.core import Relation, Scene
from spatial_relations_ros.evaluation.generalization.cases import Case, Experiment
from spatial_relations_ros.evaluation.generalization.transformable import impossible_reason


@dataclass(frozen=True, eq=False)
class Reference:
    """A demonstrated scene, on the table z = 0."""

    name: str
    relation: Relation
    scene: Scene


def paired_experiment(
    name: str,
    description: str,
    pairs: Sequence[tuple[Reference, Sequence[tuple[str, Scene]]]],
) -> Experiment:
    """Each reference with its test scenes, named, less those that cannot show its relation."""
    cases: list[Case] = []
    left_out: Counter[str] = Counter()
    for reference, tests in pairs:
        for test_name, scene in tests:
            base, relative = scene.objects
            assert base.mesh is not None
            assert relative.mesh is not None
            reason = impossible_reason(reference.relation, base.mesh, relative.mesh)
            if reason:
                left_out[reason] += 1
                continue
            cases.append(
                Case(
                    len(cases), name, reference.relation, reference.scene, scene, reference.name,
                    test_name,
                )
            )  # fmt: skip
    return Experiment(
        name,
        tuple(cases),
        description,
        tuple((reference.name, reference.relation) for reference, _ in pairs),
        left_out,
    )
