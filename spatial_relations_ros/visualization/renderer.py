"""The renderer: casts rays, shades what they meet.

One ray a pixel finds what is seen; only pixels on an edge get more rays. Shading is a soft sun
plus the sky; how much of each a place sees varies slowly and is computed on a coarser grid. The
same input gives the same picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import SceneObject
from spatial_relations_ros.visualization.camera import Camera
from spatial_relations_ros.visualization.images import Image
from spatial_relations_ros.visualization.lighting import (
    BOUNCE,
    SKY_STRENGTH,
    SUN_STRENGTH,
    Sun,
    hemispheres,
)
from spatial_relations_ros.visualization.palette import Rgb, bytes_from_linear, linear_from_srgb
from spatial_relations_ros.visualization.ray_caster import Hits, RayCaster
from spatial_relations_ros.visualization.surfaces import surface_of
from spatial_relations_ros.visualization.table import Table

FloatArray = NDArray[np.float32]

EDGE_SUBPIXELS = 3
EDGE_NORMAL_COSINE = 0.93
SUN_DIRECTIONS = 12
SUN_STRIDE = 2
SKY_DIRECTIONS = 32
SKY_STRIDE = 5
SKY_REACH = 0.6
GHOST_ALPHA = 0.27
GHOST_RIM_ALPHA = 0.5
HIGHLIGHT = 0.05
HIGHLIGHT_SHARPNESS = 24


@dataclass(frozen=True, eq=False)
class Layer:
    """Surfaces that are cast together, with the linear light that each reflects (S, 3)."""

    caster: RayCaster
    albedo: FloatArray

    @staticmethod
    def of(objects: Sequence[SceneObject], colours: Sequence[Rgb]) -> Layer:
        """A layer of objects, each with its colour."""
        albedo = linear_from_srgb(np.asarray([*colours, (0.0, 0.0, 0.0)], dtype=np.float32))
        return Layer(RayCaster([surface_of(scene_object) for scene_object in objects]), albedo)


@dataclass(frozen=True, eq=False)
class _Sight:
    """What rays through pixels (R, 2) see of both layers, in front of the table."""

    directions: FloatArray
    solid: Hits
    ghost: Hits


@dataclass(frozen=True, eq=False)
class _Seen:
    """Shares (S, H * W), 0 to 1, of sun and sky that a place of each surface sees."""

    sun: FloatArray
    sky: FloatArray


@dataclass(frozen=True, eq=False)
class Renderer:
    """One picture.

    Attributes:
        camera: where from.
        table: what the objects stand on.
        sun: the direct light.
        solid: what hides and casts shadows.
        ghost: what is laid over it, translucent.
    """

    camera: Camera
    table: Table
    sun: Sun
    solid: Layer
    ghost: Layer

    def picture(self, points: NDArray[np.floating]) -> Image:
        """The whole picture; ``points`` (N, 3) hold all that is drawn."""
        light = self.table.light(self.camera, self.solid.caster, self.sun)
        window = self._window(points)
        if window is None:
            return bytes_from_linear(light)
        rows, columns = window
        pixels = np.stack(np.meshgrid(columns, rows), axis=-1).astype(np.float32)
        shape = pixels.shape[:2]
        flat_pixels = pixels.reshape(-1, 2)
        background = light[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
        flat_background = background.reshape(-1, 3).copy()
        sight = self._look(flat_pixels)
        seen = _Seen(self._sun_share(sight, shape), self._sky_share(sight, shape))
        places = np.arange(len(flat_pixels))
        flat = self._shade(sight, flat_background, seen, places)
        edges = np.flatnonzero(_edges(sight, shape))
        flat[edges] = self._shade_finely(flat_pixels[edges], flat_background[edges], seen, edges)
        background[:] = flat.reshape(*shape, 3)
        return bytes_from_linear(light)

    def _window(
        self, points: NDArray[np.floating]
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]] | None:
        """Rows and columns that can show an object; None when all are out of the picture."""
        pixels, depth = self.camera.project(points)
        size = np.array([self.camera.width, self.camera.height])
        if (depth <= 0.0).any():
            low, high = np.zeros(2), size - 1.0
        else:
            low, high = pixels.min(axis=0) - 8.0, pixels.max(axis=0) + 8.0
        low, high = np.clip(low, 0, size).astype(int), np.clip(high, -1, size - 1).astype(int)
        if (high < low).any():
            return None
        return np.arange(low[1], high[1] + 1), np.arange(low[0], high[0] + 1)

    def _look(self, pixels: FloatArray) -> _Sight:
        directions = self.camera.ray_directions(pixels)
        table = self.table.distance(self.camera.position, directions)
        solid = self.solid.caster.first_hits(self.camera.position, directions)
        solid.surface_idx[solid.distance > table] = -1
        ghost = self.ghost.caster.first_hits(self.camera.position, directions)
        front = np.minimum(table, np.where(solid.surface_idx >= 0, solid.distance, np.inf))
        ghost.surface_idx[ghost.distance > front * (1.0 - 1e-3)] = -1
        return _Sight(directions, solid, ghost)

    def _leave(self, sight: _Sight, chosen: NDArray[np.int64]) -> FloatArray:
        """Origins (K, 3) of rays that leave the solid surfaces at the chosen hits."""
        hits = sight.solid
        places = self.camera.position + hits.distance[chosen, None] * sight.directions[chosen]
        lift = self.solid.caster.thickness(hits.surface_idx[chosen])[:, None]
        origins: FloatArray = (places + lift * hits.normal[chosen]).astype(np.float32)
        return origins

    def _sun_share(self, sight: _Sight, shape: tuple[int, int]) -> FloatArray:
        """Share of the sun's disk that each place of each surface sees, (S, H * W)."""
        facing = sight.solid.normal @ self.sun.direction.astype(np.float32) > 0.0
        chosen = _every(SUN_STRIDE, shape, facing & (sight.solid.surface_idx >= 0))
        share = self.solid.caster.visibility(
            self._leave(sight, chosen), self.sun.samples(SUN_DIRECTIONS)
        )
        return self._spread(sight, shape, chosen, share, SUN_STRIDE)

    def _sky_share(self, sight: _Sight, shape: tuple[int, int]) -> FloatArray:
        """Share of the sky that each place of each surface sees, (S, H * W)."""
        chosen = _every(SKY_STRIDE, shape, sight.solid.surface_idx >= 0)
        share = self.solid.caster.visibility(
            self._leave(sight, chosen),
            hemispheres(sight.solid.normal[chosen], SKY_DIRECTIONS),
            reach=SKY_REACH * self.table.radius,
        )
        return self._spread(sight, shape, chosen, share, SKY_STRIDE)

    def _spread(
        self,
        sight: _Sight,
        shape: tuple[int, int],
        chosen: NDArray[np.int64],
        share: FloatArray,
        stride: int,
    ) -> FloatArray:
        """Values at the chosen places, blurred over each surface apart, (S, H * W).

        Each surface keeps its own map, so that none darkens another across its outline.
        """
        owner = sight.solid.surface_idx[chosen]
        maps = np.ones((len(self.solid.albedo), *shape), dtype=np.float32)
        for surface_idx in np.unique(owner):
            mine = owner == surface_idx
            total, weight = np.zeros((2, *shape), dtype=np.float32)
            total.reshape(-1)[chosen[mine]] = share[mine]
            weight.reshape(-1)[chosen[mine]] = 1.0
            total = cv2.GaussianBlur(total, (0, 0), 0.8 * stride)
            weight = cv2.GaussianBlur(weight, (0, 0), 0.8 * stride)
            known = weight > 1e-5
            maps[surface_idx][known] = total[known] / weight[known]
        return maps.reshape(len(maps), -1)

    def _shade(
        self, sight: _Sight, background: FloatArray, seen: _Seen, places: NDArray[np.int64]
    ) -> FloatArray:
        """Linear light (R, 3) of each ray.

        Args:
            sight: what the rays see.
            background: (R, 3) where nothing solid is seen.
            seen: how much of sun and sky each place sees.
            places: (R,) index of each ray's pixel in the maps of ``seen``.
        """
        light = background.copy()
        chosen = np.flatnonzero(sight.solid.surface_idx >= 0)
        surface_idx = sight.solid.surface_idx[chosen]
        normal, view = sight.solid.normal[chosen], sight.directions[chosen]
        sun = self.sun.direction.astype(np.float32)
        facing = np.maximum(normal @ sun, 0.0) * seen.sun[surface_idx, places[chosen]]
        upward = (normal[:, 2] + 1.0) / 2.0
        ambient = seen.sky[surface_idx, places[chosen]] * (BOUNCE + (1.0 - BOUNCE) * upward)
        half = sun - view / np.sqrt(np.einsum('rc,rc->r', view, view))[:, None]
        cosine = np.einsum('rc,rc->r', normal, half) / np.sqrt(np.einsum('rc,rc->r', half, half))
        shine = HIGHLIGHT * np.maximum(cosine, 0.0) ** HIGHLIGHT_SHARPNESS * (facing > 0.05)
        strength = SKY_STRENGTH * ambient + SUN_STRENGTH * facing
        light[chosen] = self.solid.albedo[surface_idx] * strength[:, None] + shine[:, None]
        return self._veil(sight, light)

    def _veil(self, sight: _Sight, light: FloatArray) -> FloatArray:
        """Lays the ghosts over linear light (R, 3); denser where their surface turns away."""
        chosen = np.flatnonzero(sight.ghost.surface_idx >= 0)
        view = sight.directions[chosen]
        facing = np.abs((sight.ghost.normal[chosen] * view).sum(axis=1))
        rim = (1.0 - facing / np.linalg.norm(view, axis=1)) ** 2
        alpha = (GHOST_ALPHA + GHOST_RIM_ALPHA * rim)[:, None]
        albedo = self.ghost.albedo[sight.ghost.surface_idx[chosen]]
        light[chosen] = light[chosen] * (1.0 - alpha) + albedo * alpha
        return light

    def _shade_finely(
        self,
        pixels: FloatArray,
        background: FloatArray,
        seen: _Seen,
        places: NDArray[np.int64],
    ) -> FloatArray:
        """Linear light (E, 3) of pixels (E, 2), each the mean of a square of rays."""
        steps = (np.arange(EDGE_SUBPIXELS) + 0.5) / EDGE_SUBPIXELS - 0.5
        offsets = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        num_rays = len(offsets)
        fine = (pixels[:, None] + offsets).reshape(-1, 2).astype(np.float32)
        light = self._shade(
            self._look(fine),
            np.repeat(background, num_rays, axis=0),
            seen,
            np.repeat(places, num_rays),
        )
        mean: FloatArray = light.reshape(len(pixels), num_rays, 3).mean(axis=1)
        return mean


def _every(stride: int, shape: tuple[int, int], wanted: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Indices of the wanted pixels (H * W,) on every ``stride``-th row and column."""
    coarse = np.zeros(shape, dtype=bool)
    coarse[stride // 2 :: stride, stride // 2 :: stride] = True
    return np.flatnonzero(coarse.reshape(-1) & wanted)


def _edges(sight: _Sight, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Pixels (H, W) beside which another surface, or another face of it, is seen."""
    edge = np.zeros(shape, dtype=bool)
    for hits in (sight.solid, sight.ghost):
        seen = hits.surface_idx.reshape(shape)
        normal = hits.normal.reshape(*shape, 3)
        depth = hits.distance.reshape(shape)
        for near, far in (
            ((slice(None), slice(1, None)), (slice(None), slice(None, -1))),
            ((slice(1, None), slice(None)), (slice(None, -1), slice(None))),
        ):
            solid = (seen[near] >= 0) & (seen[far] >= 0)
            turned = (normal[near] * normal[far]).sum(axis=-1) < EDGE_NORMAL_COSINE
            with np.errstate(invalid='ignore'):
                jump = np.abs(depth[near] - depth[far]) > 0.02 * np.minimum(
                    depth[near], depth[far]
                )
            differs = (seen[near] != seen[far]) | (solid & (turned | jump))
            edge[near] |= differs
            edge[far] |= differs
    return edge
