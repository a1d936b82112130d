"""The ways to name a scene: of a dataset, by files, or remembered."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from spatial_relations_ros.core import Scene, SceneObject
    from spatial_relations_ros.core.pose import Pose
    from spatial_relations_ros.datasets.freiburg import RelationDataset


# The only scene whose poses need not be given: objects that stand anywhere, to be placed.
TEST_ROLE = 'test'
_STANDING_GAP = 0.05


@dataclass(frozen=True)
class SceneSource:
    """What the options of a command say about one scene.

    Attributes:
        role: word for messages and the options' prefix, such as ``reference``; empty for
            commands with one scene.
        name: of a scene of the dataset.
        data: folder of the dataset.
        base: model file of the base.
        relative: model file of the relative.
        poses: JSON file of both poses.
        remembered: name of a remembered relation.
        memory: file of remembered relations.
        objects: folder of own objects, whose names stand for their files.
    """

    role: str
    name: str | None = None
    data: Path | None = None
    base: Path | None = None
    relative: Path | None = None
    poses: Path | None = None
    remembered: str | None = None
    memory: Path | None = None
    objects: Path | None = None

    def load(self) -> Scene:
        """The scene.

        Raises:
            SpatialRelationsError: when something it is made of is missing or wrong.
        """
        self._check()
        if self.name is not None and self.data is not None:
            return read_dataset(self.data).scene(self.name)
        if self.remembered is not None:
            from spatial_relations_ros.memory import RelationMemory

            with RelationMemory(self.memory) as memory:
                return memory.get(self.remembered)
        assert self.base is not None
        assert self.relative is not None
        return scene_of_files(self.base, self.relative, self.poses, objects=self.objects)

    def _check(self) -> None:
        """One way to name the scene, and all of it."""
        prefix = f'--{self.role}-' if self.role else '--'
        files = {'base': self.base, 'relative': self.relative, 'poses': self.poses}
        given = [option for option, value in files.items() if value is not None]
        ways = [self.name is not None, bool(given), self.remembered is not None]
        named = f'--{self.role}' if self.role else '--scene'
        by_files = ', '.join(prefix + option for option in files)
        title = self.role or 'scene'
        if sum(ways) != 1:
            raise typer.BadParameter(
                f'name the {title} once: either {named} with --data, or {by_files}'
                + (f'; got {sum(ways)} ways' if sum(ways) else '')
            )
        missing = [
            prefix + option
            for option, value in files.items()
            if value is None and not (option == 'poses' and self.role == TEST_ROLE)
        ]
        if given and missing:
            raise typer.BadParameter(f'{title}: {", ".join(missing)} missing')
        if self.remembered is not None and self.memory is not None and not self.memory.is_file():
            raise typer.BadParameter(f'--memory: there is no file {self.memory}')
        if self.name is not None and self.data is None:
            raise typer.BadParameter(
                f'{named} {self.name} needs --data, the folder of its dataset'
            )


@functools.lru_cache(maxsize=2)
def read_dataset(folder: Path) -> RelationDataset:
    """A dataset folder, read once."""
    from spatial_relations_ros.datasets.freiburg import load_dataset

    return load_dataset(folder)


def scene_of_files(
    base: Path, relative: Path, poses: Path | None, *, objects: Path | None = None
) -> Scene:
    """A scene of two models and a file of their poses.

    Object ids are the files' names; ``_1`` and ``_2`` are added when both are the same.

    Args:
        base: model file in metres, or name of an own object.
        relative: likewise.
        poses: file of both poses; without one the objects stand upright on a table at z = 0,
            5 cm apart along x.
        objects: folder of own objects.
    """
    from spatial_relations_ros.core import Pose, Scene

    base_id, relative_id = base.stem, relative.stem
    if base_id == relative_id:
        base_id, relative_id = f'{base_id}_1', f'{relative_id}_2'
    from spatial_relations_ros.cli.pose_files import read_pose_file

    given = (Pose(), Pose()) if poses is None else read_pose_file(poses)
    scene = Scene(
        _object(base_id, model_file(base, objects), given[0]),
        _object(relative_id, model_file(relative, objects), given[1]),
    )
    return _standing(scene) if poses is None else scene


def model_file(path: Path, objects: Path | None = None) -> Path:
    """The file itself, or that of the own object which is named.

    Raises:
        UnknownObjectError: when a name without suffix and folder is neither.
    """
    if path.is_file() or path.suffix or len(path.parts) != 1:
        return path
    from spatial_relations_ros.datasets.own_objects import OwnObjects

    library = OwnObjects(objects)
    return library.mesh_path(library.card(str(path)).name)


def _standing(scene: Scene) -> Scene:
    """Both objects upright on a table at z = 0, beside each other."""
    import numpy as np

    from spatial_relations_ros.core import Pose

    surfaces = [item.points if item.mesh is None else item.mesh.vertices for item in scene.objects]
    lows = [surface.min(axis=0) for surface in surfaces]
    highs = [surface.max(axis=0) for surface in surfaces]
    centres = [0.5 * (low + high) for low, high in zip(lows, highs, strict=True)]
    apart = 0.5 * float(sum(high[0] - low[0] for low, high in zip(lows, highs, strict=True)))
    places = [0.0, apart + _STANDING_GAP]
    base, relative = (
        Pose(np.array([place - centre[0], -centre[1], -low[2]], dtype=np.float64))
        for place, centre, low in zip(places, centres, lows, strict=True)
    )
    return scene.with_poses(base, relative)


def _object(object_id: str, path: Path, world_from_object: Pose) -> SceneObject:
    from spatial_relations_ros.core import SceneObject
    from spatial_relations_ros.datasets.object_files import load_object_model

    mesh, points = load_object_model(path)
    return SceneObject(object_id, points, world_from_object, mesh=mesh)
