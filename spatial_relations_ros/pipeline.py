"""Frame in, objects and scenes out: the one step that live nodes and replay share."""

from __future__ import annotations

from pathlib import Path

from spatial_relations_ros.core import CloudFormatError, Scene, UnknownObjectError
from spatial_relations_ros.datasets.object_files import SAMPLED_POINTS, ObjectLibrary
from spatial_relations_ros.perception.border import Frame, FrameResult, StampedTransform
from spatial_relations_ros.perception.config import PerceptionConfig
from spatial_relations_ros.perception.object_models import KnownModel, ModelSource
from spatial_relations_ros.perception.scene_perception import ScenePerception

__all__ = ['Frame', 'FrameResult', 'LibraryModels', 'PerceptionConfig', 'Pipeline']


class LibraryModels:
    """Object models from a folder of meshes and clouds; each file is read once.

    Args:
        folder: files named by object id, as ``ObjectLibrary`` reads them.
        num_points: how many points are spread over a mesh.

    Raises:
        CloudFormatError: when the folder is missing.
    """

    def __init__(self, folder: Path | str, *, num_points: int = SAMPLED_POINTS) -> None:
        self._library = ObjectLibrary(folder, num_points=num_points)
        self._models: dict[str, KnownModel | CloudFormatError] = {}

    @property
    def object_ids(self) -> tuple[str, ...]:
        """Ids of all objects that have a file."""
        return self._library.object_ids

    def find(self, object_id: str) -> KnownModel | None:
        """The model of an object, or None when the folder has none.

        Raises:
            CloudFormatError: when its file cannot be used.
        """
        # By the file's name: a tracker that counts its objects makes new ids without end.
        name = self._library.resolve(object_id)
        if name is None:
            return None
        if name not in self._models:
            try:
                mesh, points = self._library[name]
                self._models[name] = KnownModel(points, mesh)
            except CloudFormatError as error:
                self._models[name] = error
        model = self._models[name]
        if isinstance(model, CloudFormatError):
            raise model
        return model


class Pipeline:
    """Perception over the frames of one camera, and the scenes of the last frame.

    Not safe to use from several threads: one thread feeds it, as one camera does.

    Args:
        config: how clouds and poses become objects.
        models: where the objects' models come from; without it all objects are observed.
    """

    def __init__(
        self, config: PerceptionConfig | None = None, models: ModelSource | None = None
    ) -> None:
        self._perception = ScenePerception(config, models)
        self._result: FrameResult | None = None

    @property
    def result(self) -> FrameResult | None:
        """The result of the last frame; None before the first."""
        return self._result

    def step(self, frame: Frame) -> FrameResult:
        """Makes objects of one frame; what cannot be used is in the result with its reason."""
        self._result = self._perception.step(frame)
        return self._result

    def scene(self, base_id: str, relative_id: str) -> Scene:
        """The scene of two objects in the last frame.

        Raises:
            UnknownObjectError: when an id is not among the objects; the message names those that
                are, and why this one is not.
            InvalidSceneError: when both ids are the same.
        """
        if self._result is None:
            raise UnknownObjectError(f'{base_id}, {relative_id}: no cloud has arrived yet')
        return self._result.scene(base_id, relative_id)

    def add_transform(self, transform: StampedTransform) -> None:
        """Stores a transform outside of a frame, such as a camera pose given as a parameter.

        Raises:
            FrameTransformError: when it cannot be part of a tree of frames.
        """
        self._perception.add_transform(transform)

    def configure(self, config: PerceptionConfig) -> None:
        """Uses other settings from the next frame on; objects are confirmed anew.

        Raises:
            ConfigError: for another world frame or other limits of transforms.
        """
        self._perception.configure(config)

    def reset(self) -> None:
        """Forgets tracked poses, moving transforms and the last result."""
        self._perception.reset()
        self._result = None
