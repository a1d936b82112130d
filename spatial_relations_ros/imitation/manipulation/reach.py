"""What an arm reaches: a band of distances around its shoulder, as for a PR2."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError

PR2_BAND = (0.25, 0.85)

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ArmReach:
    """Which places the arms of a robot reach, roughly.

    A place is in reach of an arm when its distance from the shoulder lies in the band. Joint
    limits, the wrist's direction and the robot's own body are the motion planner's business.

    Attributes:
        shoulders: (S, 3) in the world frame, metres; S >= 1.
        nearest: least distance from a shoulder, metres.
        farthest: greatest distance from a shoulder, metres.

    Raises:
        ConfigError: for another shape, numbers that are not finite, or an empty band.
    """

    shoulders: Array
    nearest: float = PR2_BAND[0]
    farthest: float = PR2_BAND[1]

    def __post_init__(self) -> None:
        shoulders = np.array(self.shoulders, dtype=np.float64)
        is_list = shoulders.ndim == 2 and shoulders.shape[1:] == (3,) and len(shoulders) > 0
        if not is_list or not np.isfinite(shoulders).all():
            raise ConfigError(
                f'shoulders are {shoulders.tolist()}; expected x, y, z in metres of each'
            )
        if not (0.0 <= self.nearest < self.farthest < math.inf):
            raise ConfigError(
                f'reach is {self.nearest} to {self.farthest} m; expected 0 <= nearest < farthest'
            )
        shoulders.setflags(write=False)
        object.__setattr__(self, 'shoulders', shoulders)

    def distances(self, points: Array) -> Array:
        """Metres (..., S) from points (..., 3) to each shoulder."""
        offsets = np.asarray(points)[..., None, :] - self.shoulders
        return np.asarray(np.linalg.norm(offsets, axis=-1))

    def reaching(self, points: Array) -> NDArray[np.bool_]:
        """Which arms (..., S) reach points (..., 3)."""
        distances = self.distances(points)
        return (distances >= self.nearest) & (distances <= self.farthest)

    def problems(self, name: str, places: Mapping[str, Array]) -> tuple[str, ...]:
        """Why no arm can do a task that takes one hand to several places; empty when one can.

        Args:
            name: of the object.
            places: what the object does there ("would be", for example) -> where (3,).
        """
        points = np.array(list(places.values()))
        reaching = self.reaching(points)
        if reaching.all(axis=0).any():
            return ()
        band = f'(reach {self.nearest:g} to {self.farthest:g} m)'
        nearest = self.distances(points).min(axis=1)
        missed = [
            f'{name} {verb} {nearest[k]:.2f} m from the nearest shoulder {band}'
            for k, verb in enumerate(places)
            if not reaching[k].any()
        ]
        if missed:
            return tuple(missed)
        return (f'{name} is in reach of no single arm at all of its places {band}',)
