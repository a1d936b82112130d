"""The table plane: a faint metric grid, soft shadows, fading into the background."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.visualization.camera import Camera
from spatial_relations_ros.visualization.lighting import (
    SKY_STRENGTH,
    SUN_STRENGTH,
    Sun,
    hemisphere,
)
from spatial_relations_ros.visualization.palette import HORIZON, TABLE, linear_from_srgb
from spatial_relations_ros.visualization.ray_caster import RayCaster

FloatArray = NDArray[np.float32]

GRID_STEPS = (0.001, 0.01, 0.05, 0.1, 0.5, 1.0, 5.0, 10.0)
GRID_LINES = 24
GRID_STRENGTH = 0.055
LINE_PIXELS = 1.3
SHADOW_TEXELS = 176
SUN_DIRECTIONS = 14
SKY_DIRECTIONS = 22


@dataclass(frozen=True, eq=False)
class Table:
    """A horizontal plane and what lies on it.

    Attributes:
        height: world z, metres.
        centre: (2,) world x, y of the middle of the scene.
        radius: metres from the centre that hold all objects.
        top: world z of the highest object.
    """

    height: float
    centre: NDArray[np.float64]
    radius: float
    top: float

    @staticmethod
    def below(points: NDArray[np.floating], height: float | None = None) -> Table:
        """The table under world points (N, 3); at their lowest one unless given."""
        low, high = points.min(axis=0), points.max(axis=0)
        across = float(np.linalg.norm(high[:2] - low[:2])) / 2.0
        # Tall things need some table around them too.
        radius = max(across, 0.5 * float(high[2] - low[2]), 0.01)
        return Table(
            float(low[2]) if height is None else height,
            (np.asarray(low[:2], dtype=np.float64) + high[:2]) / 2.0,
            radius,
            float(high[2]),
        )

    def distance(self, origin: NDArray[np.float64], directions: FloatArray) -> FloatArray:
        """Where rays from ``origin`` (3,) meet the plane; infinite for those that do not."""
        drop = directions[..., 2]
        with np.errstate(divide='ignore', invalid='ignore'):
            distance = np.float32(self.height - origin[2]) / drop
        return np.where((drop != 0.0) & (distance > 0.0), distance, np.float32(np.inf))

    def light(self, camera: Camera, caster: RayCaster, sun: Sun) -> FloatArray:
        """What the camera sees without the objects: linear light (H, W, 3)."""
        columns, rows = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
        directions = camera.ray_directions(np.stack([columns, rows], axis=-1))
        distance = self.distance(camera.position, directions)
        on_table = np.isfinite(distance)
        reach = np.where(on_table, distance, 0.0).astype(np.float32)
        across = (camera.position[:2] + reach[..., None] * directions[..., :2]).astype(np.float32)
        away = np.linalg.norm(across - self.centre.astype(np.float32), axis=-1) / self.radius
        presence = np.where(on_table, 1.0 - _smoothstep(1.6, 5.5, away), 0.0).astype(np.float32)
        shade = self._shadow(across, caster, sun) * (1.0 - self._grid(across))
        table, background = linear_from_srgb(TABLE), linear_from_srgb(HORIZON)
        mixed: FloatArray = background + presence[..., None] * (
            table * shade[..., None] - background
        )
        return mixed

    def _grid(self, across: FloatArray) -> FloatArray:
        """Strength of the grid lines at table points (H, W, 2), antialiased by their footprint."""
        wanted = 2.0 * self.radius / GRID_LINES * 2.0
        spacing = next((step for step in GRID_STEPS if step >= wanted), GRID_STEPS[-1])
        strength = np.zeros(across.shape[:2], dtype=np.float32)
        for axis in range(2):
            cells = across[..., axis] / np.float32(spacing)
            if min(cells.shape) < 2:
                continue
            step_row, step_column = np.gradient(cells)
            footprint = np.maximum(np.hypot(step_row, step_column), 1e-9)
            offset = np.abs(cells - np.round(cells)) / footprint
            line = np.clip(0.5 + LINE_PIXELS / 2.0 - offset, 0.0, 1.0)
            # Lines closer than a few pixels would only shimmer.
            line *= np.clip(1.5 - footprint * 5.0, 0.0, 1.0)
            strength = np.maximum(strength, line)
        grid: FloatArray = strength * np.float32(GRID_STRENGTH)
        return grid

    def _shadow(self, across: FloatArray, caster: RayCaster, sun: Sun) -> FloatArray:
        """Light at table points (H, W, 2) as a share of the light of the bare table."""
        half = self._shadow_reach(sun)
        middle = self.centre - sun.direction[:2] / sun.direction[2] * (
            max(self.top - self.height, 0.0) / 2.0
        )
        grid = (np.arange(SHADOW_TEXELS) + 0.5) / SHADOW_TEXELS * 2.0 - 1.0
        texels = np.empty((SHADOW_TEXELS, SHADOW_TEXELS, 3), dtype=np.float32)
        texels[..., 0] = middle[0] + half * grid[None, :]
        texels[..., 1] = middle[1] + half * grid[:, None]
        texels[..., 2] = self.height + 2e-4 * half
        flat = texels.reshape(-1, 3)
        sunny = caster.visibility(flat, sun.samples(SUN_DIRECTIONS))
        open_sky = caster.visibility(flat, hemisphere(SKY_DIRECTIONS), reach=half)
        direct = SUN_STRENGTH * sun.direction[2]
        shade = (direct * sunny + SKY_STRENGTH * open_sky) / (direct + SKY_STRENGTH)
        shade_map = cv2.GaussianBlur(shade.reshape(SHADOW_TEXELS, SHADOW_TEXELS), (5, 5), 0)
        scale = SHADOW_TEXELS / (2.0 * half)
        columns = ((across[..., 0] - middle[0] + half) * scale - 0.5).astype(np.float32)
        rows = ((across[..., 1] - middle[1] + half) * scale - 0.5).astype(np.float32)
        shadow: FloatArray = cv2.remap(
            shade_map, columns, rows, cv2.INTER_LINEAR, borderValue=(1.0,)
        )
        return shadow

    def _shadow_reach(self, sun: Sun) -> float:
        """Half the side of the square that holds all shadows, metres."""
        height = max(self.top - self.height, 0.0)
        slope = float(np.linalg.norm(sun.direction[:2]) / sun.direction[2])
        return 1.35 * self.radius + height * slope / 2.0 + 0.5 * height


def _smoothstep(low: float, high: float, values: FloatArray) -> FloatArray:
    share = np.clip((values - low) / (high - low), 0.0, 1.0)
    smooth: FloatArray = share * share * (3.0 - 2.0 * share)
    return smooth
