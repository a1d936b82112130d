"""Publishes answers: target poses for a planner, details and markers for people."""

from __future__ import annotations

import re

from geometry_msgs.msg import PoseArray, PoseStamped
from spatial_relations_msgs.msg import Imitation, MovePlan
from visualization_msgs.msg import MarkerArray

from spatial_relations_ros.core import Scene
from spatial_relations_ros.imitation import ImitationResult
from spatial_relations_ros.ros.conversions import header_to_msg, pose_stamped
from spatial_relations_ros.ros.imitation_markers import imitation_markers
from spatial_relations_ros.ros.imitation_messages import (
    answer_to_msg,
    plan_to_msg,
    targets_to_pose_array,
)
from spatial_relations_ros.ros.qos import ANSWERS
from spatial_relations_ros.ros.relations_node import RelationsNode

MAX_TARGET_TOPICS = 64


def topic_token(object_id: str) -> str:
    """An object id as one part of a topic name."""
    token = re.sub(r'[^A-Za-z0-9_]', '_', object_id)
    token = re.sub('__+', '_', token)
    return f'_{token}' if token[:1].isdigit() else token


class AnswerPublisher:
    """Publishes the best answer.

    Topics: ``target_poses``, ``target_pose/<object id>``, with a grasp also
    ``gripper_target/<object id>`` and ``gripper_approach/<object id>``; ``~/moves``,
    ``~/imitation`` and ``~/markers``.
    """

    def __init__(self, node: RelationsNode) -> None:
        self._node = node
        self._poses = node.create_publisher(PoseArray, 'target_poses', ANSWERS)
        self._imitation = node.create_publisher(Imitation, '~/imitation', ANSWERS)
        self._markers = node.create_publisher(MarkerArray, '~/markers', ANSWERS)
        self._moves = node.create_publisher(MovePlan, '~/moves', ANSWERS)
        self._targets: dict[str, object] = {}

    def publish(self, result: ImitationResult, reference: Scene, test: Scene) -> None:
        """Publishes the best answer.

        ``~/imitation`` and ``~/markers`` carry it whatever it is; target poses go out when the
        request succeeded, so that a robot does not follow what cannot stand.
        """
        if not result.answers:
            return
        best = result.answers[0]
        header = header_to_msg(test.stamp_ns, test.frame_id)
        self._imitation.publish(answer_to_msg(best, header))
        self._markers.publish(imitation_markers(best, reference, test, header))
        is_wanted = result.success or self._node.parameters.flag('publish_infeasible')
        if result.cancelled or not is_wanted:
            return
        self._poses.publish(targets_to_pose_array(best, header))
        self._moves.publish(plan_to_msg(best, header))
        for placement in best.placements:
            poses = {
                'target_pose': placement.target,
                'gripper_target': placement.gripper_target,
                'gripper_approach': placement.gripper_approach,
            }
            for name, pose in poses.items():
                if pose is not None:
                    publisher = self._target_publisher(name, placement.object_id)
                    publisher.publish(pose_stamped(pose, header))  # type: ignore[attr-defined]

    def _target_publisher(self, name: str, object_id: str) -> object:
        topic = f'{name}/{topic_token(object_id)}'
        if topic not in self._targets:
            if len(self._targets) >= MAX_TARGET_TOPICS:
                oldest = next(iter(self._targets))
                self._node.destroy_publisher(self._targets.pop(oldest))
            self._targets[topic] = self._node.create_publisher(PoseStamped, topic, ANSWERS)
        return self._targets[topic]
