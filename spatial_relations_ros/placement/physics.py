"""Whether a scene stays as it is when it is let go, by simulation in MuJoCo (optional)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.core.rotations import matrix_from_quat_wxyz
from spatial_relations_ros.placement.body import FloatArray, Placed

FRICTION = 0.8
SECONDS = 1.0
MAX_SHIFT = 0.02
MAX_TURN_RAD = float(np.deg2rad(15.0))
_TIMESTEP = 0.002
_TORSION, _ROLLING = 0.005, 0.0001
# Time constant and damping of contacts: five times as stiff as by default, with which a heavy
# object on a light one sinks in by a millimetre and tips.
_SOLREF = [0.004, 1.0]


@dataclass(frozen=True)
class Motion:
    """How a body moved: shift of its bounding box's middle in metres, turn in radians."""

    shift: float
    turn_rad: float

    @property
    def stayed(self) -> bool:
        """Whether it moved by at most 2 cm and 15 degrees."""
        return self.shift <= MAX_SHIFT and self.turn_rad <= MAX_TURN_RAD


def settle(
    bodies: Sequence[Placed], *, seconds: float = SECONDS, friction: float = FRICTION
) -> list[Motion]:
    """Lets bodies go on the table z = 0 and simulates them.

    Bodies are sums of convex parts with their density, everything has the same friction.

    Args:
        bodies: watertight, at poses in one world.
        seconds: of simulated time.
        friction: of all surfaces, sliding.

    Returns:
        How far each has moved in the end; a simulation that diverges counts as far away.

    Raises:
        ConfigError: where MuJoCo is not installed.
    """
    mujoco = _mujoco()
    model = _model(mujoco, bodies, friction)
    state = mujoco.MjData(model)
    mujoco.mj_forward(model, state)
    before = _poses(state, len(bodies))
    for _ in range(round(seconds / _TIMESTEP)):
        mujoco.mj_step(model, state)
    after = _poses(state, len(bodies))
    return [_motion(*pair) for pair in zip(before, after, strict=True)]


def _mujoco() -> ModuleType:
    try:
        import mujoco
    except ImportError as error:
        raise ConfigError(
            'simulations need MuJoCo: pip install mujoco, or the package with its extra physics'
        ) from error
    module: ModuleType = mujoco
    return module


def _model(mujoco: ModuleType, bodies: Sequence[Placed], friction: float) -> Any:
    """A world with a table and one free body for each of the bodies."""
    spec = mujoco.MjSpec()
    spec.option.timestep = _TIMESTEP
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    coefficients = [friction, _TORSION, _ROLLING]
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0.0, 0.0, 0.01],
        friction=coefficients,
        solref=_SOLREF,
    )
    for number, placed in enumerate(bodies):
        pose = placed.pose()
        body = spec.worldbody.add_body(
            name=f'body{number}', pos=pose.translation, quat=pose.quat_wxyz
        )
        body.add_freejoint()
        for part_number, part in enumerate(placed.body.convex_parts):
            name = f'mesh{number}_{part_number}'
            spec.add_mesh(name=name, uservert=part.points.ravel())
            body.add_geom(
                type=mujoco.mjtGeom.mjGEOM_MESH,
                meshname=name,
                density=placed.body.model.density * part.filled,
                friction=coefficients,
                solref=_SOLREF,
            )
    return spec.compile()


def _poses(state: Any, num_bodies: int) -> list[tuple[FloatArray, FloatArray]]:
    """Positions (3,) and rotations (3, 3) of all bodies but the world."""
    return [
        (state.xpos[idx].copy(), matrix_from_quat_wxyz(state.xquat[idx].copy()))
        for idx in range(1, num_bodies + 1)
    ]


def _motion(before: tuple[FloatArray, FloatArray], after: tuple[FloatArray, FloatArray]) -> Motion:
    shift = float(np.linalg.norm(after[0] - before[0]))
    cosine = 0.5 * (float(np.trace(after[1] @ before[1].T)) - 1.0)
    turn_rad = float(np.arccos(np.clip(cosine, -1.0, 1.0)))
    if not np.isfinite([shift, turn_rad]).all():
        return Motion(float('inf'), float(np.pi))
    return Motion(shift, turn_rad)
