"""perception_node: clouds and tracked poses in, scenes out."""

from __future__ import annotations

import math
import sys
import threading
import time
from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import PointCloud2
from spatial_relations_msgs.msg import TrackedObjectArray
from spatial_relations_msgs.srv import GetScene
from tf2_msgs.msg import TFMessage

from spatial_relations_ros.core import (
    CloudFormatError,
    FrameTransformError,
    InvalidSceneError,
    UnknownObjectError,
)
from spatial_relations_ros.nodes.frame_worker import FrameWorker
from spatial_relations_ros.nodes.node_recording import NodeRecording, log_frame
from spatial_relations_ros.nodes.perception_parameters import (
    ASSEMBLY_PARAMETERS,
    PERCEPTION_PARAMETERS,
    PIPELINE_PARAMETERS,
    assembly_config,
    make_pipeline,
    perception_config,
)
from spatial_relations_ros.nodes.perception_states import clouds_state, objects_state
from spatial_relations_ros.nodes.scene_publisher import ScenePublisher
from spatial_relations_ros.perception.assembler import FrameAssembler
from spatial_relations_ros.perception.border import (
    Frame,
    FrameResult,
    TrackedPose,
    TrackFault,
)
from spatial_relations_ros.perception.messages import (
    read_detections,
    read_pose_stamped,
    read_tracked_objects,
    read_transforms,
    stamp_ns,
)
from spatial_relations_ros.perception.point_cloud2 import read_xyz
from spatial_relations_ros.perception.pose_topics import pose_topics
from spatial_relations_ros.ros import qos
from spatial_relations_ros.ros.conversions import (
    cloud_to_msg,
    header_to_msg,
    scene_object_to_msg,
    scene_to_msg,
)
from spatial_relations_ros.ros.diagnostics import State
from spatial_relations_ros.ros.latency import Latencies
from spatial_relations_ros.ros.relations_node import RelationsNode
from spatial_relations_ros.ros.running import run_node

try:
    from vision_msgs.msg import Detection3DArray
except ImportError:  # optional: one of several sources of poses
    Detection3DArray = None

POINTS = '~/points'
STATIC_TRANSFORMS = '/tf_static'


class PerceptionNode(RelationsNode):
    """Gives the scenes of tracked objects as of the latest cloud."""

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__('perception_node', PERCEPTION_PARAMETERS, **node_arguments)
        try:
            self._set_up()
        except Exception:  # half a node must not stay in the graph
            self.destroy_node()
            raise

    def _set_up(self) -> None:
        self._pipeline = make_pipeline(self.parameters)
        # Static transforms go into it from the thread of their topic.
        self._pipeline_lock = threading.Lock()
        self._result_lock = threading.Lock()
        self._latest: FrameResult | None = None
        self._latest_arrival_sec = -math.inf
        self._latencies = Latencies()
        self._scenes = ScenePublisher(self)
        self._recording = NodeRecording(self)
        self._worker = FrameWorker(
            FrameAssembler(assembly_config(self.parameters)),
            self._handle,
            lambda: self.get_clock().now().nanoseconds,
        )
        self._subscribe_to_poses()
        is_reliable = self.parameters.flag('reliable_points')
        self.subscribe(
            PointCloud2, POINTS, self._on_points, qos.latest_cloud(is_reliable=is_reliable)
        )
        self.serve(GetScene, '~/get_scene', self._get_scene, may_wait=False)
        self.diagnostics.add_state('objects', self._objects_state)
        self.diagnostics.add_state('clouds', self._clouds_state)
        self.parameters.on_change(PIPELINE_PARAMETERS, self._configure_pipeline)
        self.parameters.on_change(ASSEMBLY_PARAMETERS, self._configure_assembler)

    def _configure_pipeline(self) -> None:
        with self._pipeline_lock:
            self._pipeline.configure(perception_config(self.parameters))

    def _configure_assembler(self) -> None:
        with self._worker.assembler() as assembler:
            assembler.configure(assembly_config(self.parameters))

    def reset(self) -> str:
        """Forgets objects, poses and moving transforms; models and static transforms stay."""
        with self._worker.assembler() as assembler:
            assembler.reset()
        with self._pipeline_lock:
            self._pipeline.reset()
            with self._result_lock:
                self._latest, self._latest_arrival_sec = None, -math.inf
            self._latencies.clear()
        return 'objects, tracked poses, moving transforms, waiting clouds, counters'

    def close(self) -> None:
        """Ends the thread of perception."""
        super().close()
        if hasattr(self, '_worker'):  # not when the parameters could not be used
            self._worker.close()
            self._recording.close()

    def destroy_node(self) -> None:
        """Ends the thread of perception, then what it publishes with."""
        self.close()
        super().destroy_node()

    def _subscribe_to_poses(self) -> None:
        self.subscribe(
            TrackedObjectArray,
            '~/tracked_objects',
            lambda msg: self._add_tracks(*read_tracked_objects(msg)),
            qos.TRACKED_POSES,
        )
        for object_id, topic in pose_topics(self.parameters.texts('pose_topics')).items():
            self._subscribe_to_pose(object_id, topic)
        if Detection3DArray is not None:
            self.subscribe(
                Detection3DArray,
                '~/detections',
                lambda msg: self._add_tracks(*read_detections(msg)),
                qos.TRACKED_POSES,
            )
        self.subscribe(TFMessage, '/tf', self._on_transforms, qos.TRANSFORMS)
        self.subscribe(
            TFMessage, STATIC_TRANSFORMS, self._on_static_transforms, qos.STATIC_TRANSFORMS
        )

    def _subscribe_to_pose(self, object_id: str, topic: str) -> None:
        def on_pose(msg: PoseStamped) -> None:
            self._add_tracks(*read_pose_stamped(msg, object_id))

        self.subscribe(PoseStamped, topic, on_pose, qos.TRACKED_POSES)

    def _add_tracks(self, tracks: Sequence[TrackedPose], faults: Sequence[TrackFault]) -> None:
        with self._worker.assembler() as assembler:
            assembler.add_tracks(tracks, faults)

    def _on_transforms(self, msg: TFMessage) -> None:
        transforms, faults = read_transforms(msg, is_static=False)
        with self._worker.assembler() as assembler:
            assembler.add_transforms(transforms, faults)

    def _on_static_transforms(self, msg: TFMessage) -> None:
        """Stored at once: they come only once and must not be crowded out while no cloud comes."""
        transforms, faults = read_transforms(msg, is_static=True)
        with self._worker.assembler() as assembler:
            assembler.add_transforms((), faults)
        with self._pipeline_lock:
            for transform in transforms:
                try:
                    self._pipeline.add_transform(transform)
                except FrameTransformError as error:  # the others of a latched message count
                    self.report_bad(STATIC_TRANSFORMS, error)

    def _on_points(self, msg: PointCloud2) -> None:
        if not msg.header.frame_id:
            raise CloudFormatError('the cloud comes without a frame_id')
        self._latencies.arrived(stamp_ns(msg.header.stamp))
        cloud = read_xyz(msg)
        now_ns = self.get_clock().now().nanoseconds
        with self._worker.assembler() as assembler:
            assembler.add_cloud(stamp_ns(msg.header.stamp), msg.header.frame_id, cloud, now_ns)

    def _handle(self, frame: Frame) -> None:
        """On the worker's thread: nothing that goes wrong with a frame may end it."""
        try:
            self._step(frame)
            self._latencies.done(frame.stamp_ns)
        except Exception as error:
            if self.context.ok():  # else publishers are gone, and so is the log
                self.report_bad(POINTS, error)

    def _step(self, frame: Frame) -> None:
        with self._pipeline_lock:
            result = self._pipeline.step(frame)
            with self._result_lock:
                self._latest, self._latest_arrival_sec = result, time.monotonic()
        self._recording.record(result.stamp_ns, lambda to: log_frame(to, result))
        if result.problem is not None:
            self.report_bad(POINTS, InvalidSceneError(result.problem))
            return
        self._scenes.publish(result)

    def _get_scene(self, request: GetScene.Request, response: GetScene.Response) -> None:
        object_ids = list(request.object_ids)
        if len(object_ids) != 2:
            raise InvalidSceneError(
                f'expected two object ids, [base, relative], got {len(object_ids)}: {object_ids}'
            )
        result = self._fresh_result()
        table_height = result.table_height
        response.scene = scene_to_msg(result.scene(*object_ids))
        response.table_height = math.nan if table_height is None else float(table_height)
        if request.with_others:
            _fill_others(response, result, object_ids)
        response.success = True

    def _fresh_result(self) -> FrameResult:
        """The result of the latest cloud, not older than ``max_age``."""
        with self._result_lock:
            latest, age_sec = self._latest, time.monotonic() - self._latest_arrival_sec
        topic = self.resolve_topic_name(POINTS)
        if latest is None:
            raise UnknownObjectError(
                f'no point cloud that can be read has arrived on {topic}; is the sensor running '
                'and the topic remapped?'
            )
        max_age_sec = self.parameters.number('max_age')
        if max_age_sec and age_sec > max_age_sec:
            raise UnknownObjectError(
                f'the last cloud on {topic} came {age_sec:.1f} s ago, max_age is '
                f'{max_age_sec:g} s; is the sensor still running?'
            )
        return latest

    def _clouds_state(self) -> State:
        with self._worker.assembler() as assembler:
            return clouds_state(assembler, self._latencies)

    def _objects_state(self) -> State:
        with self._result_lock:
            latest, age_sec = self._latest, time.monotonic() - self._latest_arrival_sec
        return objects_state(latest, age_sec)


def _fill_others(
    response: GetScene.Response, result: FrameResult, object_ids: Sequence[str]
) -> None:
    """What else is seen: other objects, and points that belong to none."""
    header = header_to_msg(result.stamp_ns, result.frame_id)
    response.others = [
        scene_object_to_msg(item, header)
        for object_id, item in result.objects.items()
        if object_id not in object_ids
    ]
    if result.obstacles is not None:
        response.clutter = cloud_to_msg(result.obstacles, header)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the node until it is asked to stop; returns the exit code."""
    return run_node(PerceptionNode, arguments, may_wait=False)


if __name__ == '__main__':
    sys.exit(main())
