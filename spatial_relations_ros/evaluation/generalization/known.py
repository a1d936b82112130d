"""The paper's first experiment: scenes of known objects imitated with each other's objects."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from spatial_relations_ros.core import DatasetFormatError, Relation, Scene, TriangleMesh
from spatial_relations_ros.datasets.freiburg import RelationDataset, RelationScene
from spatial_relations_ros.datasets.solidify import solid_from_cloud, watertight
from spatial_relations_ros.evaluation.generalization.cases import Experiment, on_table
from spatial_relations_ros.evaluation.generalization.pairing import Reference, paired_experiment
from spatial_relations_ros.evaluation.judging import judge_scene

KNOWN = 'known'
# Those of the paper, with its labels.
PAPER_REFERENCES: Mapping[str, Relation] = {
    'coffeMensa_colorPlate_8335': Relation.ON_TOP,
    'shampoo2_sweetener_881': Relation.ON_TOP,
    'bowl_sweetener_3349': Relation.INSIDE,
    'SmallBoxBase_milkCarton_6983': Relation.INSIDE,
    'tea1_zucker_8027': Relation.NEXT_TO,
    'thuna_salz_5333': Relation.NEXT_TO,
    'SmallBoxBase_bowl_4380': Relation.INCLINED,
    'rice_tea1_3271': Relation.INCLINED,
    'rice_thuna_745': Relation.ON_TOP_EDGE,
    'muesli2_bowl_5885': Relation.ON_TOP_EDGE,
    'pot4_salz_6424': Relation.INSIDE_LYING,
    'pot4_oil_3767': Relation.INSIDE_INCLINED,
    'SmallBoxBase_oil_222': Relation.INSIDE_INCLINED,
}

_STREAM = 11


class SolidScenes:
    """Scenes of a dataset, on the table, with watertight meshes.

    Meshes that are not watertight are closed; of objects without a mesh the cloud is taken for
    the surface of a solid. Each object is made solid once, so that scenes share its mesh.
    """

    def __init__(self, dataset: RelationDataset) -> None:
        self.dataset = dataset
        self._meshes: dict[str, TriangleMesh] = {}

    def scene(self, entry: RelationScene) -> Scene:
        """The scene of an entry.

        Raises:
            InvalidSceneError: when an object's mesh or cloud encloses nothing.
        """
        scene = self.dataset.scene_of(entry)
        base, relative = (
            dataclasses.replace(item, mesh=self._mesh(item.object_id)) for item in scene.objects
        )
        return on_table(Scene(base, relative))

    def _mesh(self, object_id: str) -> TriangleMesh:
        if object_id not in self._meshes:
            mesh = self.dataset.meshes.get(object_id)
            self._meshes[object_id] = (
                solid_from_cloud(self.dataset.clouds[object_id])
                if mesh is None
                else watertight(mesh)
            )
        return self._meshes[object_id]


def draw_references(dataset: RelationDataset, *, seed: int) -> tuple[Reference, ...]:
    """The paper's 13 scenes where the dataset has them, else as many drawn alike.

    As in the paper two of each relation and one in a lying container. Drawn ones are such whose
    label geometry confirms, and as far as possible no two have an object in common.

    Raises:
        DatasetFormatError: when the dataset has no labelled scenes, or the judge confirms none.
        InvalidSceneError: when an object's mesh or cloud encloses nothing.
    """
    solids = SolidScenes(dataset)
    if set(PAPER_REFERENCES) <= set(dataset.scene_by_name):
        return tuple(
            Reference(name, relation, solids.scene(dataset.scene_by_name[name]))
            for name, relation in PAPER_REFERENCES.items()
        )
    rng = np.random.default_rng([seed, _STREAM])
    wanted = Counter(PAPER_REFERENCES.values())
    used: set[str] = set()
    references: list[Reference] = []
    for relation in Relation:
        entries = [entry for entry in dataset.scenes if entry.label is relation]
        shuffled = [entries[idx] for idx in rng.permutation(len(entries))]
        chosen = _confirmed(solids, shuffled, wanted[relation], used)
        references += [Reference(name, relation, scene) for name, scene in chosen]
    if not references:
        raise DatasetFormatError(
            f'none of the {len(dataset.scenes)} scenes has a label that its geometry confirms'
        )
    return tuple(references)


def _confirmed(
    solids: SolidScenes, entries: Sequence[RelationScene], count: int, used: set[str]
) -> list[tuple[str, Scene]]:
    """The first ``count`` scenes whose label the judge confirms; their objects are noted.

    Scenes of objects that were used before come after all others.
    """
    chosen: dict[str, Scene] = {}
    for only_new in (True, False):
        for entry in entries:
            names = {entry.base_id, entry.relative_id}
            if len(chosen) == count or entry.name in chosen or (only_new and names & used):
                continue
            scene = solids.scene(entry)
            if judge_scene(scene, 0.0).relation is entry.label:
                chosen[entry.name] = scene
                used |= names
    return list(chosen.items())


def known_experiment(references: Sequence[Reference]) -> Experiment:
    """All ordered pairs of a reference and the objects of another scene, less impossible ones."""
    return paired_experiment(
        KNOWN,
        f'{len(references)} scenes, each imitated with the objects of every other; both objects '
        'may move',
        [
            (reference, [(test.name, test.scene) for test in references if test is not reference])
            for reference in references
        ],
    )
