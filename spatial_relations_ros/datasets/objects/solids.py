"""Watertight building blocks, by constructive solid geometry."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from manifold3d import CrossSection, Manifold, OpType
from numpy.typing import NDArray

from spatial_relations_ros.core import TriangleMesh

NUM_SEGMENTS = 48
SIMPLIFY_TOLERANCE = 2e-5

Profile = Sequence[tuple[float, float]]


def revolve(profile: Profile, *, num_segments: int = NUM_SEGMENTS) -> Manifold:
    """Solid of revolution about z of a closed outline of ``(radius, z)`` points, metres."""
    outline = np.asarray(profile, dtype=np.float64)
    following = np.roll(outline, -1, axis=0)
    area = (outline[:, 0] * following[:, 1] - following[:, 0] * outline[:, 1]).sum()
    if area < 0.0:
        outline = outline[::-1]
    return CrossSection([outline]).revolve(num_segments)


def solid_of_wall(wall: Profile) -> Manifold:
    """Everything within an outer wall ``[(radius, z), ...]`` that runs from bottom to top."""
    return revolve([(0.0, wall[0][1]), *wall, (0.0, wall[-1][1])])


def vessel_of_wall(
    wall: Profile, *, thickness: float, floor_thickness: float
) -> tuple[Manifold, Manifold]:
    """A hollow vessel open at the top, and the cavity that was cut from it.

    The inner wall runs ``thickness`` (horizontally) inside of the outer wall, the floor is
    ``floor_thickness`` above the lowest point of the wall.
    """
    floor = wall[0][1] + floor_thickness
    heights = [z for _, z in wall]
    radii = [radius for radius, _ in wall]
    rim = wall[-1][1]
    inner_floor = max(float(np.interp(floor, heights, radii)) - thickness, 1e-3)
    inner = [(inner_floor, floor)]
    inner += [(max(r - thickness, 1e-3), z) for r, z in wall if floor + 1e-4 < z < rim - 1e-4]
    inner.append((max(radii[-1] - thickness, 1e-3), rim))
    over = (inner[-1][0], rim + 0.05)
    cavity = revolve([(0.0, floor), *inner, over, (0.0, over[1])])
    return solid_of_wall(wall) - cavity, cavity


def box(size: Sequence[float], *, bottom: float = 0.0) -> Manifold:
    """Box of a size (x, y, z) that is centred in x and y and stands at a height."""
    return Manifold.cube(tuple(size), True).translate((0.0, 0.0, bottom + size[2] / 2.0))


def tapered_box(
    bottom: tuple[float, float], top: tuple[float, float], height: float, *, radius: float = 0.0
) -> Manifold:
    """Box with another size (x, y) at the top than at the bottom; round upright edges."""
    section = CrossSection.square((bottom[0] - 2 * radius, bottom[1] - 2 * radius), True)
    if radius > 0.0:
        section = section.offset(radius, circular_segments=16)
    scale = (top[0] / bottom[0], top[1] / bottom[1])
    return Manifold.extrude(section, height, scale_top=scale)


def rounded_box(size: Sequence[float], radius: float) -> Manifold:
    """Box that stands on z = 0, centred in x and y, with all edges rounded."""
    half = [length / 2.0 - radius for length in size]
    corner = Manifold.sphere(radius, 12)
    corners = [
        corner.translate((x * half[0], y * half[1], size[2] / 2.0 + z * half[2]))
        for x in (-1, 1)
        for y in (-1, 1)
        for z in (-1, 1)
    ]
    return Manifold.batch_hull(corners)


def prism(outline: Profile, depth: float) -> Manifold:
    """Upright outline of ``(x, z)`` points, counter-clockwise, as thick as ``depth`` along y."""
    solid = Manifold.extrude(CrossSection([np.asarray(outline, dtype=np.float64)]), depth)
    return solid.translate((0.0, 0.0, -depth / 2.0)).rotate((90.0, 0.0, 0.0))


def oval(width: float, depth: float, height: float, *, top_share: float = 1.0) -> Manifold:
    """Upright cylinder on an ellipse, scaled at the top."""
    section = CrossSection.circle(0.5, 40).scale((width, depth))
    return Manifold.extrude(section, height, scale_top=(top_share, top_share))


def rod_through(points: Sequence[Sequence[float]], radii: Sequence[float]) -> Manifold:
    """Round rod along a chain of points, with a radius at each."""
    balls = [
        Manifold.sphere(radius, 16).translate(tuple(point))
        for point, radius in zip(points, radii, strict=True)
    ]
    links = [Manifold.batch_hull([a, b]) for a, b in pairwise(balls)]
    return Manifold.batch_boolean(links, OpType.Add)


def ball(centre: Sequence[float], radii: Sequence[float]) -> Manifold:
    """Ellipsoid."""
    return Manifold.sphere(1.0, 24).scale(tuple(radii)).translate(tuple(centre))


def flat_below(solid: Manifold, height: float) -> Manifold:
    """Cuts off what is below a height, so that the solid stands."""
    return solid.trim_by_plane((0.0, 0.0, 1.0), height)


def capsule(start: Sequence[float], end: Sequence[float], radius: float) -> Manifold:
    """Rod with round ends."""
    end_ball = Manifold.sphere(radius, 12)
    return Manifold.batch_hull([end_ball.translate(tuple(start)), end_ball.translate(tuple(end))])


def loop(
    half_width: float, half_height: float, rod_radius: float, *, flatness: float = 1.0
) -> Manifold:
    """Closed elliptic ring in the x-z plane around the origin, for handles.

    ``flatness`` stretches the rod's section along y.
    """
    radius = max(half_width, half_height)
    section = CrossSection.circle(rod_radius, 10).translate((radius, 0.0))
    ring = section.revolve(32).rotate((90.0, 0.0, 0.0))
    return ring.scale((half_width / radius, flatness, half_height / radius))


def mesh_of(solid: Manifold) -> TriangleMesh:
    """Triangles of a solid.

    Raises:
        ValueError: for an empty solid.
    """
    if solid.is_empty():
        raise ValueError('the solid is empty')
    mesh = solid.simplify(SIMPLIFY_TOLERANCE).to_mesh()
    vertices: NDArray[np.float32] = np.array(mesh.vert_properties, dtype=np.float32)[:, :3]
    # Cuts leave copies of a vertex, one for each of the solids that meet there.
    merged = np.arange(len(vertices), dtype=np.int32)
    merged[np.asarray(mesh.merge_from_vert, dtype=np.int64)] = mesh.merge_to_vert
    used, triangles = np.unique(merged[mesh.tri_verts], return_inverse=True)
    return TriangleMesh(vertices[used], triangles.reshape(-1, 3).astype(np.int32))
