"""What a rolling ball cannot reach: the solid that a surface with gaps encloses."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import open3d as o3d
from manifold3d import Error, Manifold, Mesh
from numpy.typing import NDArray
from scipy import ndimage, spatial

from spatial_relations_ros.core import TriangleMesh

NUM_TRIANGLES = 5000

# Below this a ball slips through between the nodes.
_MIN_BALL_CELLS = 1.75
# Half of the thickness, in cells, at which nodes see a wall without holes.
_MIN_DEPTH_CELLS = 0.6

# Openings narrower than twice this share of the extent are taken for holes in the data.
_CLOSED_OPENING_SHARE = 1.0 / 16.0

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]


class _Grid(NamedTuple):
    """Nodes ``origin + spacing * index`` around a cloud."""

    origin: Array
    spacing: float
    counts: tuple[int, int, int]

    def position(self, nodes: NDArray[np.integer]) -> Array:
        return self.origin + self.spacing * nodes


def enclosed_solid(
    cloud: Array,
    distance: Callable[[Array], Array],
    *,
    spacing: float,
    radius: float,
    sink: float = 0.0,
) -> TriangleMesh:
    """What a ball that rolls over a surface from outside cannot reach.

    Args:
        cloud: (N, 3), on the surface.
        distance: from positions (M, 3) to the surface, (M,).
        spacing: of the grid.
        radius: of the ball; at least 1.75 times the spacing is used.
        sink: how far the ball sinks into the surface in the mean.

    Returns:
        A watertight mesh of at most about 5,000 triangles.
    """
    radius = max(radius, _MIN_BALL_CELLS * spacing)
    large = max(radius, _CLOSED_OPENING_SHARE * float(np.ptp(cloud, axis=0).max()))
    grid = _grid_around(cloud, spacing, margin=large)
    reached, crossings = _roll_ball(cloud, distance, grid, (radius, large))
    values = _signed_distances(reached, crossings, grid, radius) - sink
    _thicken_sheets(values, spacing)
    return _surface_of(values, grid)


def _grid_around(cloud: Array, spacing: float, *, margin: float) -> _Grid:
    cells = int(np.ceil(margin / spacing)) + 2
    low, high = cloud.min(axis=0), cloud.max(axis=0)
    counts = np.ceil((high - low) / spacing).astype(int) + 2 * cells + 1
    # Half a cell off, so that faces along the axes do not coincide with nodes.
    return _Grid(low - (cells - 0.5) * spacing, spacing, tuple(counts))


def _roll_ball(
    cloud: Array, distance: Callable[[Array], Array], grid: _Grid, radii: tuple[float, float]
) -> tuple[Bools, Array]:
    """Nodes where the ball's centre can be, coming from outside; and points on their border.

    Cavities that a ball of the second radius cannot enter are not entered.
    """
    radius, large = radii
    occupied = np.zeros(grid.counts, dtype=bool)
    occupied[tuple(np.rint((cloud - grid.origin) / grid.spacing).astype(int).T)] = True
    distances = ndimage.distance_transform_edt(~occupied) * grid.spacing
    # Exact where it decides; the distance to occupied nodes is off by less than a cell.
    near = np.argwhere(np.abs(distances - radius) < 1.5 * grid.spacing)
    distances[tuple(near.T)] = distance(grid.position(near))
    reached = _from_outside(distances > radius)
    reached &= ~_closed_cavities(distances, reached, grid.spacing, large)
    crossings = []
    for axis in range(3):
        here, there = [slice(None)] * 3, [slice(None)] * 3
        here[axis], there[axis] = slice(None, -1), slice(1, None)
        border = np.argwhere(reached[tuple(here)] != reached[tuple(there)])
        before = distances[tuple(here)][tuple(border.T)]
        after = distances[tuple(there)][tuple(border.T)]
        positions = grid.position(border)
        # Across the opening of a closed cavity both lie beyond the radius.
        share = (before - radius) / np.where(before == after, 1.0, before - after)
        positions[:, axis] += grid.spacing * np.clip(share, 0.0, 1.0)
        crossings.append(positions)
    return reached, np.concatenate(crossings)


def _from_outside(free: Bools) -> Bools:
    """Free nodes that hang together with those at the grid's border."""
    labels, _ = ndimage.label(free)
    outside: Bools = labels == labels[0, 0, 0]
    return outside


def _closed_cavities(distances: Array, reached: Bools, spacing: float, large: float) -> Bools:
    """Nodes of cavities in which a large ball has room but which it cannot enter.

    Scans have holes where the scanner did not see, and a hollow shell is not what was scanned.
    """
    free = distances > large
    entered = _from_outside(free)
    rooms = free & ~entered
    if not rooms.any():
        return rooms
    swept = ndimage.distance_transform_edt(~entered) * spacing <= large
    labels, _ = ndimage.label(reached & ~swept)
    found = np.unique(labels[rooms])
    closed: Bools = np.isin(labels, found[found > 0])
    return closed


def _signed_distances(reached: Bools, crossings: Array, grid: _Grid, radius: float) -> Array:
    """To the surface that the ball touches, at nodes; negative inside."""
    depth = ndimage.distance_transform_edt(~reached) * grid.spacing
    values: Array = radius - depth
    near = np.argwhere(~reached & (np.abs(values) < 1.7 * grid.spacing))
    values[tuple(near.T)] = radius - spatial.KDTree(crossings).query(grid.position(near))[0]
    return values


def _thicken_sheets(values: Array, spacing: float) -> None:
    """Moves the surface outwards where a wall is too thin to be seen by nodes."""
    depth = -ndimage.minimum_filter(values, size=5)
    values -= np.clip(_MIN_DEPTH_CELLS * spacing - depth, 0.0, _MIN_DEPTH_CELLS * spacing)


def _surface_of(values: Array, grid: _Grid) -> TriangleMesh:
    """The zero level, simplified."""
    # Exact zeros make triangles without area.
    values[np.abs(values) < 1e-3 * grid.spacing] = -1e-3 * grid.spacing
    volume = np.ascontiguousarray(values.transpose(2, 1, 0), dtype=np.float32)
    level = o3d.t.geometry.TriangleMesh.create_isosurfaces(
        o3d.core.Tensor.from_numpy(volume), [0.0]
    )
    vertices = grid.position(level.vertex.positions.numpy()).astype(np.float32)
    triangles = level.triangle.indices.numpy()[:, ::-1].astype(np.int32)
    solid = _as_manifold(vertices, triangles)
    if solid is None:
        return TriangleMesh(vertices, triangles)
    tolerance = grid.spacing / 8.0
    while solid.num_tri() > NUM_TRIANGLES and tolerance < grid.spacing:
        simpler = solid.simplify(tolerance)
        if simpler.is_empty():
            break
        solid = simpler
        tolerance *= 1.5
    return _mesh_of(solid)


def _as_manifold(vertices: NDArray[np.float32], triangles: NDArray[np.int32]) -> Manifold | None:
    solid = Manifold(Mesh(vertices, triangles.astype(np.uint32)))
    return solid if solid.status() == Error.NoError and solid.num_tri() > 0 else None


def _mesh_of(solid: Manifold) -> TriangleMesh:
    mesh = solid.to_mesh()
    return TriangleMesh(
        np.array(mesh.vert_properties, dtype=np.float32)[:, :3],
        np.array(mesh.tri_verts, dtype=np.int32),
    )
