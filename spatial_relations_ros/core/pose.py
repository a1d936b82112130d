"""Rigid poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core.errors import InvalidPoseError
from spatial_relations_ros.core.rotations import (
    FloatArray,
    matrix_from_quat_wxyz,
    quat_wxyz_from_matrix,
    quat_wxyz_product,
)

QUATERNION_NORM_TOLERANCE = 0.05


def _readonly(values: FloatArray) -> FloatArray:
    values = np.array(values, dtype=np.float64)
    values.setflags(write=False)
    return values


@dataclass(frozen=True, eq=False)
class Pose:
    """A rigid transform; read a variable ``world_from_object`` as target_from_source.

    Attributes:
        translation: (3,) float64, metres.
        quat_wxyz: (4,) float64 unit quaternion, scalar first. A norm within 5 % of one is
            normalised (trackers round), anything else is refused.

    Raises:
        InvalidPoseError: for wrong shapes, non-finite numbers, or a quaternion that is far from
            unit length.
    """

    translation: FloatArray = field(default_factory=lambda: np.zeros(3))
    quat_wxyz: FloatArray = field(default_factory=lambda: np.array([1.0, 0.0, 0.0, 0.0]))

    def __post_init__(self) -> None:
        try:
            translation = np.asarray(self.translation, dtype=np.float64)
            quat_wxyz = np.asarray(self.quat_wxyz, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InvalidPoseError(f'a pose needs numbers: {error}') from error
        if translation.shape != (3,) or quat_wxyz.shape != (4,):
            raise InvalidPoseError(
                f'got a translation of shape {translation.shape} and a quaternion of shape '
                f'{quat_wxyz.shape}; expected (3,) and (4,)'
            )
        if not (np.isfinite(translation).all() and np.isfinite(quat_wxyz).all()):
            raise InvalidPoseError(
                f'pose is not finite: t={translation.tolist()}, q_wxyz={quat_wxyz.tolist()}'
            )
        norm = float(np.linalg.norm(quat_wxyz))
        if abs(norm - 1.0) > QUATERNION_NORM_TOLERANCE:
            raise InvalidPoseError(
                f'quaternion {quat_wxyz.tolist()} (w, x, y, z) has norm {norm:.4g}; '
                'a rotation needs a unit quaternion'
            )
        object.__setattr__(self, 'translation', _readonly(translation))
        object.__setattr__(self, 'quat_wxyz', _readonly(quat_wxyz / norm))

    @staticmethod
    def identity() -> Pose:
        """The pose that changes nothing."""
        return Pose()

    @staticmethod
    def from_matrix(matrix: FloatArray) -> Pose:
        """Pose of a homogeneous (4, 4) matrix; its rotation part must be orthonormal."""
        matrix = np.asarray(matrix, dtype=np.float64)
        if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
            raise InvalidPoseError(f'expected a finite (4, 4) matrix, got {matrix.tolist()}')
        rotation = matrix[:3, :3]
        if np.abs(rotation @ rotation.T - np.eye(3)).max() > 1e-3 or np.linalg.det(rotation) < 0:
            raise InvalidPoseError(f'{rotation.tolist()} is not a rotation matrix')
        return Pose(matrix[:3, 3], quat_wxyz_from_matrix(rotation))

    @staticmethod
    def from_rotation(rotation: FloatArray, translation: Sequence[float] | FloatArray) -> Pose:
        """Pose of a (3, 3) rotation matrix and a translation (3,) in metres."""
        matrix = np.eye(4)
        matrix[:3, :3] = rotation
        matrix[:3, 3] = translation
        return Pose.from_matrix(matrix)

    @cached_property
    def rotation(self) -> FloatArray:
        """The (3, 3) rotation matrix."""
        return _readonly(matrix_from_quat_wxyz(self.quat_wxyz))

    def as_matrix(self) -> FloatArray:
        """The homogeneous (4, 4) matrix."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation
        matrix[:3, 3] = self.translation
        return matrix

    def apply(self, points: NDArray[np.floating]) -> FloatArray:
        """Transforms points (..., 3) from the source to the target frame, as float64."""
        return np.asarray(points, dtype=np.float64) @ self.rotation.T + self.translation

    def __matmul__(self, other: Pose) -> Pose:
        """``a_from_b @ b_from_c`` is ``a_from_c``."""
        return Pose(
            self.rotation @ other.translation + self.translation,
            quat_wxyz_product(self.quat_wxyz, other.quat_wxyz),
        )

    def inverse(self) -> Pose:
        """``world_from_object.inverse()`` is ``object_from_world``."""
        conjugate = self.quat_wxyz * np.array([1.0, -1.0, -1.0, -1.0])
        return Pose(-self.rotation.T @ self.translation, conjugate)

    def is_close(self, other: Pose, *, metres: float = 1e-6, angle_rad: float = 1e-6) -> bool:
        """Whether both poses agree within a distance and a rotation angle."""
        delta = self.inverse() @ other
        angle = 2.0 * np.arctan2(np.linalg.norm(delta.quat_wxyz[1:]), abs(delta.quat_wxyz[0]))
        return bool(np.linalg.norm(delta.translation) <= metres and angle <= angle_rad)
