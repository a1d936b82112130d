"""What poses alone tell of a scene: how both objects lie, lean, and are apart."""

from __future__ import annotations

import enum
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import Pose

FloatArray = NDArray[np.float64]

_LEVEL_DEG = 12.0


class Attitude(enum.Enum):
    """How an object's upright axis points."""

    UPRIGHT = 'upright'
    SIDE = 'on its side'
    UPSIDE_DOWN = 'upside down'
    TILTED = 'tilted'

    @staticmethod
    def of(axis_angle_deg: float) -> Attitude:
        """From the angle between the upright axis and up, 0 to 180 degrees."""
        if axis_angle_deg < _LEVEL_DEG:
            return Attitude.UPRIGHT
        if axis_angle_deg > 180.0 - _LEVEL_DEG:
            return Attitude.UPSIDE_DOWN
        return Attitude.SIDE if abs(axis_angle_deg - 90.0) < _LEVEL_DEG else Attitude.TILTED


@dataclass(frozen=True)
class PosedPair:
    """A scene without its clouds."""

    name: str
    base_id: str
    relative_id: str
    world_from_base: Pose
    world_from_relative: Pose


@dataclass(frozen=True)
class PoseQuantities:
    """Numbers of one scene.

    Attributes:
        base_axis_deg: angle between the base's upright axis and up.
        relative_axis_deg: likewise of the relative.
        tilt_deg: of the relative's upright axis from the nearest of up, down and level.
        height: of the relative's origin above the base's, metres.
        distance: horizontal, between the origins, metres.
    """

    base_axis_deg: float
    relative_axis_deg: float
    height: float
    distance: float

    @property
    def tilt_deg(self) -> float:
        """Of the relative's upright axis from the nearest of up, down and level."""
        angle = self.relative_axis_deg
        return min(angle, 180.0 - angle, abs(90.0 - angle))

    @property
    def attitudes(self) -> tuple[Attitude, Attitude]:
        """Of base and relative."""
        return Attitude.of(self.base_axis_deg), Attitude.of(self.relative_axis_deg)


def upright_axes(pairs: Iterable[PosedPair]) -> dict[str, FloatArray]:
    """The model axis (3,) of each object that most often points up."""
    ups: dict[str, list[FloatArray]] = {}
    for pair in pairs:
        ups.setdefault(pair.base_id, []).append(pair.world_from_base.rotation[2])
        ups.setdefault(pair.relative_id, []).append(pair.world_from_relative.rotation[2])
    candidates = np.concatenate([np.eye(3)[[2, 1, 0]], -np.eye(3)[[2, 1, 0]]])
    cosine = np.cos(np.deg2rad(_LEVEL_DEG))
    axes = {}
    for object_id, directions in ups.items():
        counts = (np.array(directions) @ candidates.T > cosine).sum(axis=0)
        axes[object_id] = candidates[int(np.argmax(counts))]
    return axes


def pose_quantities(
    pairs: Sequence[PosedPair], axes: Mapping[str, FloatArray]
) -> list[PoseQuantities]:
    """The numbers of each scene, given the objects' upright axes."""
    rows = []
    for pair in pairs:
        offset = pair.world_from_relative.translation - pair.world_from_base.translation
        rows.append(
            PoseQuantities(
                _axis_angle_deg(pair.world_from_base, axes[pair.base_id]),
                _axis_angle_deg(pair.world_from_relative, axes[pair.relative_id]),
                height=float(offset[2]),
                distance=float(np.hypot(offset[0], offset[1])),
            )
        )
    return rows


def _axis_angle_deg(pose: Pose, axis: FloatArray) -> float:
    cosine = float(pose.rotation[2] @ axis)
    return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))
