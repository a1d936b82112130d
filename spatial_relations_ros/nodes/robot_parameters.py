"""Parameters about the robot: what it reaches, how it grasps, what it must not touch."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError, InvalidPoseError, Pose, Scene
from spatial_relations_ros.core.rotations import wxyz_from_xyzw
from spatial_relations_ros.imitation import ArmReach, ImitationOptions, Obstacle
from spatial_relations_ros.imitation.manipulation import without_strays
from spatial_relations_ros.nodes.scene_client import SeenScene
from spatial_relations_ros.nodes.transform_listener import TransformListener
from spatial_relations_ros.ros.parameters import ParameterSpec
from spatial_relations_ros.ros.relations_node import RelationsNode

ROBOT_PARAMETERS = (
    ParameterSpec(
        'avoid_others',
        True,
        'Keep what is placed clear of all other things that perception sees.',
    ),
    ParameterSpec(
        'shoulder_positions',
        [],
        "Shoulders of the robot's arms in the world, x y z of each in one list, metres; without "
        'any shoulder reach is not checked.',
        is_numbers=True,
        is_fixed=True,
    ),
    ParameterSpec(
        'shoulder_frames', [], 'Further shoulders: origins of /tf frames.', is_fixed=True
    ),
    ParameterSpec(
        'reach_min',
        ArmReach.nearest,
        'Least distance from the shoulder that an arm reaches, metres.',
        minimum=0.0,
        maximum=100.0,
    ),
    ParameterSpec(
        'reach_max',
        ArmReach.farthest,
        'Greatest distance from the shoulder that an arm reaches, metres.',
        minimum=0.0,
        maximum=100.0,
    ),
    ParameterSpec(
        'grasps',
        [],
        'Where the gripper holds an object, in its frame: "mug=x y z qx qy qz qw" each.',
        is_fixed=True,
    ),
    ParameterSpec(
        'grasp_frames',
        [],
        'Objects that are held where a /tf frame is when a request comes: '
        '"mug=r_gripper_tool_frame" each.',
        is_fixed=True,
    ),
)

Array = NDArray[np.float64]


class Robot:
    """What a request's options need to know of the robot and of what stands around.

    Raises:
        ConfigError: for parameters that cannot be used.
    """

    def __init__(self, node: RelationsNode) -> None:
        parameters = node.parameters
        self._parameters = parameters
        self._shoulders = shoulder_positions(parameters.numbers('shoulder_positions'))
        self._shoulder_frames = parameters.texts('shoulder_frames')
        self._grasps = grasps(parameters.texts('grasps'))
        self._grasp_frames = grasp_frames(parameters.texts('grasp_frames'))
        needs_transforms = bool(self._shoulder_frames or self._grasp_frames)
        self._transforms = TransformListener(node) if needs_transforms else None

    @property
    def avoids_others(self) -> bool:
        """Whether what else is seen counts as an obstacle."""
        return self._parameters.flag('avoid_others')

    def options(self, options: ImitationOptions, seen: SeenScene) -> ImitationOptions:
        """The options with obstacles, arm and grasps.

        Raises:
            ConfigError: when reach_min is not below reach_max.
            FrameTransformError: when a frame of the parameters is not known.
        """
        return dataclasses.replace(
            options,
            obstacles=obstacles_of(seen) if self.avoids_others else (),
            arm=self._arm(seen.scene),
            grasps={**self._grasps, **self._grasps_by_frames(seen.scene)},
        )

    def _arm(self, scene: Scene) -> ArmReach | None:
        shoulders = [*self._shoulders, *(
            self._world_from(frame, scene).translation for frame in self._shoulder_frames
        )]  # fmt: skip
        if not shoulders:
            return None
        parameters = self._parameters
        return ArmReach(
            np.array(shoulders), parameters.number('reach_min'), parameters.number('reach_max')
        )

    def _grasps_by_frames(self, scene: Scene) -> dict[str, Pose]:
        return {
            item.object_id: item.world_from_object.inverse() @ self._world_from(frame, scene)
            for item in scene.objects
            if (frame := self._grasp_frames.get(item.object_id)) is not None
        }

    def _world_from(self, frame: str, scene: Scene) -> Pose:
        assert self._transforms is not None
        return self._transforms.world_from(scene.frame_id, frame, scene.stamp_ns)


def obstacles_of(seen: SeenScene) -> tuple[Obstacle, ...]:
    """Everything that was seen beside the two objects of the scene."""
    obstacles = [Obstacle.of_object(item) for item in seen.others]
    clutter = np.zeros((0, 3)) if seen.clutter is None else without_strays(seen.clutter)
    if len(clutter):
        obstacles.append(Obstacle.of_cloud(clutter, 'something unknown'))
    return tuple(obstacles)


def shoulder_positions(numbers: Sequence[float]) -> Array:
    """Positions (S, 3) of a flat list.

    Raises:
        ConfigError: when they are no triples.
    """
    if len(numbers) % 3:
        raise ConfigError(
            f'shoulder_positions has {len(numbers)} numbers; expected x, y, z of each shoulder'
        )
    return np.array(numbers, dtype=np.float64).reshape(-1, 3)


def grasps(entries: Sequence[str]) -> dict[str, Pose]:
    """object_from_gripper by object id, of entries "mug=x y z qx qy qz qw".

    Raises:
        ConfigError: for any other entry.
    """
    found = {}
    for entry in entries:
        object_id, text = _split(entry, 'grasps', '"mug=x y z qx qy qz qw"')
        try:
            numbers = np.array([float(part) for part in text.replace(',', ' ').split()])
            if len(numbers) != 7:
                raise ValueError(f'{len(numbers)} numbers')
            found[object_id] = Pose(numbers[:3], wxyz_from_xyzw(numbers[3:]))
        except (ValueError, InvalidPoseError) as error:
            raise ConfigError(
                f'grasps has {entry!r}, expected "mug=x y z qx qy qz qw": {error}'
            ) from None
    return found


def grasp_frames(entries: Sequence[str]) -> dict[str, str]:
    """Frames by object id, of entries "mug=frame".

    Raises:
        ConfigError: for any other entry.
    """
    return dict(_split(entry, 'grasp_frames', '"mug=frame"') for entry in entries)


def _split(entry: str, parameter: str, expected: str) -> tuple[str, str]:
    object_id, _, value = (part.strip() for part in entry.partition('='))
    if not object_id or not value:
        raise ConfigError(f'{parameter} has {entry!r}; expected {expected}')
    return object_id, value
