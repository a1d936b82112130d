"""From a cloud and tracked poses to objects in the world: the one step of live and replay."""

from __future__ import annotations

from collections.abc import Mapping

from spatial_relations_ros.core import (
    ConfigError,
    FrameTransformError,
    InvalidPoseError,
    Pose,
    SceneObject,
)
from spatial_relations_ros.perception.beliefs import Beliefs
from spatial_relations_ros.perception.border import (
    Frame,
    FrameResult,
    StampedTransform,
    TrackedPose,
)
from spatial_relations_ros.perception.camera import estimate_camera
from spatial_relations_ros.perception.config import PerceptionConfig
from spatial_relations_ros.perception.frames import TransformBuffer, clean_frame_id
from spatial_relations_ros.perception.object_finder import ObjectFinder, Seen
from spatial_relations_ros.perception.object_models import ModelSource, NoModels
from spatial_relations_ros.perception.series import NS_PER_SEC
from spatial_relations_ros.perception.surroundings import (
    obstacles,
    table_around,
    table_height,
    thin_world_points,
)
from spatial_relations_ros.perception.track_state import (
    Evidence,
    Observation,
    TrackState,
    TrackStatus,
)
from spatial_relations_ros.perception.tracks import TrackBuffer, TrackRejectedError
from spatial_relations_ros.perception.view import View


class ScenePerception:
    """Remembers transforms and tracked poses; makes objects of each cloud.

    The results depend on nothing but the frames that were given, in their order: a replayed bag
    gives the same results each time.

    Args:
        config: how clouds and poses become objects.
        models: where the objects' models come from; without it all objects are observed.
    """

    def __init__(
        self, config: PerceptionConfig | None = None, models: ModelSource | None = None
    ) -> None:
        self.config = config or PerceptionConfig()
        self.transforms = TransformBuffer(self.config.transforms)
        self._tracks = TrackBuffer(self.config.tracks)
        self._models = models or NoModels()
        self._last_stamp_ns: int | None = None
        self._begin_beliefs()

    def _begin_beliefs(self) -> None:
        self._beliefs = Beliefs(self.config)
        self._finder = ObjectFinder(self.config, self._models, self._beliefs)

    def configure(self, config: PerceptionConfig) -> None:
        """Uses other settings from the next frame on.

        Poses, transforms and models stay; objects are confirmed anew.

        Raises:
            ConfigError: for another world frame or other limits of transforms: what is
                remembered was stored for those.
        """
        if (config.world_frame, config.transforms) != (
            self.config.world_frame,
            self.config.transforms,
        ):
            raise ConfigError('world_frame and limits of transforms cannot change any more')
        self.config = config
        self._tracks.configure(config.tracks)
        self._begin_beliefs()

    def add_transform(self, transform: StampedTransform) -> None:
        """Stores a transform outside of a frame, such as a camera pose given as a parameter.

        Raises:
            FrameTransformError: when it cannot be part of a tree of frames.
        """
        self.transforms.add(transform)

    def reset(self) -> None:
        """Forgets objects and moving transforms, as after a jump of the clock."""
        self._tracks.clear()
        self._beliefs.clear()
        self._finder.observed.clear()
        self.transforms.forget_moving()
        self._last_stamp_ns = None

    def step(self, frame: Frame) -> FrameResult:
        """Makes objects of one frame.

        Nothing that a sensor or tracker sends makes this raise: what cannot be used is in the
        result with its reason.
        """
        faults = self._remember(frame)
        if frame.cloud.is_empty:
            return self._unusable(
                frame, f'no finite points in the cloud of {frame.cloud.num_total}'
            )
        try:
            world_from_cloud = self.transforms.lookup(
                self.config.world_frame, frame.frame_id, frame.stamp_ns
            )
        except FrameTransformError as error:
            return self._unusable(frame, f'the cloud cannot be used: {error}')
        poses, refused = self._poses(frame.stamp_ns, faults)
        known, rejected = self._finder.find_models(poses)
        thin_points = thin_world_points(frame.cloud, world_from_cloud, self.config)
        table = table_around(thin_points, poses, self.config)
        camera = estimate_camera(frame.cloud)
        view = View(frame.cloud, camera, world_from_cloud.as_matrix(), table)
        self._finder.refine(known, view)
        poses |= {object_id: pose for object_id, (_, pose) in known.items()}
        seen = {object_id: self._finder.see(object_id, poses, known, view) for object_id in poses}
        objects, states = self._believed(frame.stamp_ns, seen, refused, poses)
        rejected |= {key: status.reason for key, status in states.items() if key not in objects}
        unread = {key: reason for key, reason in faults.items() if key not in objects}
        return FrameResult(
            stamp_ns=frame.stamp_ns,
            frame_id=self.config.world_frame,
            objects=objects,
            rejected=unread | rejected,
            states=states,
            table_height=table_height(table, poses, thin_points),
            obstacles=obstacles(
                thin_points,
                table,
                [known[object_id] for object_id in objects if object_id in known],
                objects.values(),
                self.config.crop.table_margin,
            )
            if self.config.find_obstacles
            else None,
        )

    def _remember(self, frame: Frame) -> dict[str, str]:
        """Takes up what came with the frame; gives the reasons for what could not be used."""
        jump_ns = self.config.tracks.jump_back_sec * NS_PER_SEC
        if self._last_stamp_ns is not None and frame.stamp_ns < self._last_stamp_ns - jump_ns:
            self.reset()
        self._last_stamp_ns = frame.stamp_ns
        faults = {fault.object_id: fault.reason for fault in frame.faults}
        for transform in frame.transforms:
            try:
                self.transforms.add(transform)
            except FrameTransformError as error:
                faults[transform.child_frame] = str(error)
                continue
            child, parent = (
                clean_frame_id(name) for name in (transform.child_frame, transform.parent_frame)
            )
            if child in self.config.object_frames and not transform.is_static:
                pose = transform.parent_from_child
                self._beliefs.add(TrackedPose(child, transform.stamp_ns, parent, pose))
        for track in frame.tracks:
            self._tracks.add(track)
            self._beliefs.add(track)
        self._beliefs.doubt_jumps()
        return faults

    def _unusable(self, frame: Frame, problem: str) -> FrameResult:
        object_ids = (*self._tracks.object_ids, *self.config.object_frames)
        return FrameResult(
            stamp_ns=frame.stamp_ns,
            frame_id=self.config.world_frame,
            rejected=dict.fromkeys(object_ids, problem),
            problem=problem,
        )

    def _poses(
        self, stamp_ns: int, faults: Mapping[str, str]
    ) -> tuple[dict[str, Pose], dict[str, str]]:
        """``world_from_object`` of each object that has one now, and why others have none."""
        poses: dict[str, Pose] = {}
        refused: dict[str, str] = {}
        world = self.config.world_frame
        for object_id in sorted({*self._tracks.object_ids, *self.config.object_frames}):
            try:
                if object_id in self._tracks.object_ids:
                    poses[object_id] = self._tracks.world_from_object(
                        object_id, stamp_ns, self.transforms, world
                    )
                else:
                    poses[object_id] = self.transforms.lookup(world, object_id, stamp_ns)
            except (TrackRejectedError, FrameTransformError, InvalidPoseError) as error:
                refused[object_id] = str(error)
                if object_id in faults:
                    refused[object_id] += f'; since then: {faults[object_id]}'
        return poses, refused

    def _believed(
        self,
        stamp_ns: int,
        seen: Mapping[str, Seen],
        refused: Mapping[str, str],
        poses: Mapping[str, Pose],
    ) -> tuple[dict[str, SceneObject], dict[str, TrackStatus]]:
        """The objects that may be used, and the states of all."""
        observations = {object_id: observation for object_id, (_, observation) in seen.items()}
        for object_id, reason in refused.items():
            observations[object_id] = Observation(Evidence.CONTRADICTED, reason=reason)
        self._finder.observed.keep(frozenset(observations))
        states = self._beliefs.update(stamp_ns, observations, poses)
        objects: dict[str, SceneObject] = {}
        for object_id, status in states.items():
            item = seen[object_id][0] if object_id in seen else None
            usable = status.state is TrackState.TRACKED or (
                status.state is TrackState.UNCERTAIN and self.config.use_uncertain
            )
            if item is not None and usable:
                objects[object_id] = item
            if status.state is TrackState.LOST:
                self._finder.observed.forget(object_id)
        return objects, states
