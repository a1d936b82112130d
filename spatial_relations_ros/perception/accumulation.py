"""What was seen of an object over time, in its own frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError

# Voxel indices are packed into 64 bits, 21 each.
_HALF_RANGE = 1 << 20


@dataclass(frozen=True)
class AccumulationConfig:
    """How much is remembered of an object without a model.

    Attributes:
        voxel: of one voxel's points one is kept, metres.
        max_points: how many are kept of an object; those seen least often go first.
        min_hits: in how many clouds a voxel must have been seen to count.
        max_hits: more are not counted, so that what is gone is forgotten after as many clouds
            that look through it.
        min_consistency: when clouds confirm less than this share of what was seen before, the
            object did not move as its pose did, and its memory starts anew.
    """

    voxel: float = 0.004
    max_points: int = 20_000
    min_hits: int = 2
    max_hits: int = 30
    min_consistency: float = 0.3

    def __post_init__(self) -> None:
        if not 0.0005 <= self.voxel <= 0.1:
            raise ConfigError(f'the voxel is 0.0005 to 0.1 m, got {self.voxel}')
        if self.max_points < 100 or not 1 <= self.min_hits <= self.max_hits:
            raise ConfigError(f'at least 100 points and 1 <= min_hits <= max_hits, got {self}')
        if not 0 <= self.min_consistency <= 1:
            raise ConfigError(f'min_consistency is {self.min_consistency}, expected 0 to 1')


class AccumulatedCloud:
    """Voxels with how often each was seen."""

    def __init__(self, config: AccumulationConfig | None = None) -> None:
        self._config = config or AccumulationConfig()
        self._keys: NDArray[np.int64] = np.zeros(0, dtype=np.int64)
        self._points: NDArray[np.float32] = np.zeros((0, 3), dtype=np.float32)
        self._hits: NDArray[np.int64] = np.zeros(0, dtype=np.int64)

    def __len__(self) -> int:
        return len(self._keys)

    @property
    def all_points(self) -> NDArray[np.float32]:
        """(N, 3) one point of each voxel, object frame, metres."""
        return self._points

    @property
    def points(self) -> NDArray[np.float32]:
        """Those of ``all_points`` that were seen often enough to count."""
        return self._points[self._hits >= self._config.min_hits]

    def add(self, points: NDArray[np.floating]) -> None:
        """Takes in points (N, 3) of one cloud, object frame."""
        keys, first = np.unique(self._keys_of(points), return_index=True)
        seen = np.asarray(points)[first].astype(np.float32)
        known, place = self._find(keys)
        rows = place[known]
        self._hits[rows] = np.minimum(self._hits[rows] + 1, self._config.max_hits)
        # The running mean: a tracker's jitter averages out.
        self._points[rows] += (seen[known] - self._points[rows]) / self._hits[rows, None]
        self._keys = np.concatenate([self._keys, keys[~known]])
        self._points = np.concatenate([self._points, seen[~known]])
        self._hits = np.concatenate([self._hits, np.ones(np.count_nonzero(~known), np.int64)])
        surplus = len(self._keys) - self._config.max_points
        if surplus > 0:
            # Stable: the same clouds keep the same points.
            keep = np.argsort(self._hits, kind='stable')[surplus:]
            self._pick(keep)
        self._pick(np.argsort(self._keys))

    def miss(self, is_gone: NDArray[np.bool_]) -> None:
        """Counts against voxels (N,) that a cloud looked through; forgets those it outweighs."""
        self._hits[is_gone] -= 1
        self._pick(np.flatnonzero(self._hits > 0))

    def unseen_in(self, points: NDArray[np.floating]) -> NDArray[np.float32]:
        """Those of ``points`` that are not beside points of a live cloud (N, 3).

        Beside is in the same cell of twice a voxel: a sensor's noise spreads a surface over more
        than one voxel.
        """
        remembered = self.points
        known = np.isin(self._keys_of(remembered, 2), self._keys_of(points, 2))
        return remembered[~known]

    def _keys_of(self, points: NDArray[np.floating], num_voxels: int = 1) -> NDArray[np.int64]:
        cell = num_voxels * self._config.voxel
        voxels = np.floor(np.asarray(points, dtype=np.float64) / cell)
        voxels = np.clip(voxels, -_HALF_RANGE, _HALF_RANGE - 1).astype(np.int64) + _HALF_RANGE
        keys: NDArray[np.int64] = (voxels[:, 0] << 42) | (voxels[:, 1] << 21) | voxels[:, 2]
        return keys

    def _find(self, keys: NDArray[np.int64]) -> tuple[NDArray[np.bool_], NDArray[np.intp]]:
        """Which keys are known, and the row of each (meaningless for others)."""
        if not len(self._keys):
            return np.zeros(len(keys), dtype=bool), np.zeros(len(keys), dtype=np.intp)
        place = np.minimum(np.searchsorted(self._keys, keys), len(self._keys) - 1)
        return self._keys[place] == keys, place

    def _pick(self, rows: NDArray[np.intp]) -> None:
        self._keys, self._points = self._keys[rows], self._points[rows]
        self._hits = self._hits[rows]
