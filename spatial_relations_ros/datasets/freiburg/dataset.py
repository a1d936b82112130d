"""A dataset of labelled scenes, in memory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import (
    DatasetFormatError,
    Pose,
    Relation,
    Scene,
    SceneObject,
    TriangleMesh,
)


@dataclass(frozen=True, eq=False)
class RelationScene:
    """Two objects at their poses.

    Attributes:
        name: ``object1_object2_number``.
        base_id: object 1.
        relative_id: object 2.
        world_from_base: its translation is zero in files of the paper.
        world_from_relative: in the same world, z up.
        label: the relation, or None where it is not labelled.
    """

    name: str
    base_id: str
    relative_id: str
    world_from_base: Pose
    world_from_relative: Pose
    label: Relation | None = None


@dataclass(frozen=True)
class Split:
    """Scene names for training and for testing."""

    name: str
    train: tuple[str, ...]
    test: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class RelationDataset:
    """Clouds, scenes and splits.

    Attributes:
        clouds: points (N, 3) float32 by object id, object frame, metres.
        scenes: in the file's order.
        splits: the cross-validation splits of the paper (over scenes).
        object_splits: splits in which no object of a test scene is in a training scene.
        meshes: watertight meshes by object id, where they are known.
    """

    clouds: Mapping[str, NDArray[np.float32]]
    scenes: tuple[RelationScene, ...]
    splits: tuple[Split, ...] = ()
    object_splits: tuple[Split, ...] = ()
    meshes: Mapping[str, TriangleMesh] = field(default_factory=dict)

    @cached_property
    def scene_by_name(self) -> Mapping[str, RelationScene]:
        """Scenes by their names."""
        return {scene.name: scene for scene in self.scenes}

    @property
    def labels(self) -> NDArray[np.int64]:
        """Label of each scene (S,), -1 where there is none."""
        return np.array(
            [-1 if scene.label is None else int(scene.label) for scene in self.scenes],
            dtype=np.int64,
        )

    def scene(self, name: str) -> Scene:
        """The scene of a name, with clouds (and meshes where known).

        Raises:
            DatasetFormatError: for a name that is not in the dataset.
        """
        try:
            entry = self.scene_by_name[name]
        except KeyError:
            known = [scene.name for scene in self.scenes[:6]]
            raise DatasetFormatError(
                f'no scene {name!r}; the dataset has {len(self.scenes)} scenes such as '
                f'{", ".join(known)}'
            ) from None
        return self.scene_of(entry)

    def scene_of(self, entry: RelationScene) -> Scene:
        """A scene with clouds (and meshes where known)."""
        base, relative = (
            SceneObject(object_id, self.clouds[object_id], pose, mesh=self.meshes.get(object_id))
            for object_id, pose in (
                (entry.base_id, entry.world_from_base),
                (entry.relative_id, entry.world_from_relative),
            )
        )
        return Scene(base, relative)
