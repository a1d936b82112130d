"""Building blocks, boards and stands."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold

from spatial_relations_ros.datasets.objects.materials import PLASTIC, WOOD
from spatial_relations_ros.datasets.objects.model_of_solid import model_of_solid
from spatial_relations_ros.datasets.objects.solids import (
    box,
    prism,
    revolve,
    rounded_box,
    solid_of_wall,
)
from spatial_relations_ros.placement.model import ObjectModel


def make_cube(rng: np.random.Generator) -> ObjectModel:
    """Cube or nearly so."""
    side = rng.uniform(0.035, 0.11)
    size = (side, side * rng.uniform(0.9, 1.1), side * rng.uniform(0.9, 1.1))
    return model_of_solid('cube', box(size), dict(zip('xyz', size, strict=True)), density=WOOD)


def make_brick(rng: np.random.Generator) -> ObjectModel:
    """Long block or beam."""
    size = (rng.uniform(0.12, 0.26), rng.uniform(0.035, 0.07), rng.uniform(0.025, 0.06))
    return model_of_solid('brick', box(size), dict(zip('xyz', size, strict=True)), density=WOOD)


def make_wedge(rng: np.random.Generator) -> ObjectModel:
    """Wedge: a door stop, a slice of cake."""
    length, height = rng.uniform(0.08, 0.16), rng.uniform(0.04, 0.09)
    depth, tip = rng.uniform(0.045, 0.10), rng.uniform(0.004, 0.02)
    solid = prism([(0, 0), (length, 0), (length, height), (0, tip)], depth)
    return model_of_solid(
        'wedge', solid, {'length': length, 'height': height, 'depth': depth}, density=WOOD
    )


def make_ell(rng: np.random.Generator) -> ObjectModel:
    """L-shaped block: a book end, an angle bracket."""
    length, height = rng.uniform(0.08, 0.16), rng.uniform(0.08, 0.17)
    thick, depth = rng.uniform(0.012, 0.035), rng.uniform(0.05, 0.12)
    outline = [(0, 0), (length, 0), (length, thick), (thick, thick), (thick, height), (0, height)]
    return model_of_solid(
        'ell',
        prism(outline, depth),
        {'length': length, 'height': height, 'thickness': thick, 'depth': depth},
        density=WOOD,
    )


def make_bridge(rng: np.random.Generator) -> ObjectModel:
    """Block with an arch through it."""
    size = (rng.uniform(0.11, 0.18), rng.uniform(0.04, 0.08), rng.uniform(0.06, 0.10))
    radius = min(size[0] * rng.uniform(0.22, 0.32), 0.8 * size[2])
    hole = Manifold.cylinder(2 * size[1], radius, radius, 32).rotate((90.0, 0.0, 0.0))
    return model_of_solid(
        'bridge',
        box(size) - hole.translate((0, size[1], 0)),
        {**dict(zip('xyz', size, strict=True)), 'radius': radius},
        density=WOOD,
    )


def make_tee(rng: np.random.Generator) -> ObjectModel:
    """T-shaped stand: a foot and an upright plate."""
    length, height = rng.uniform(0.09, 0.14), rng.uniform(0.09, 0.16)
    thick, depth = rng.uniform(0.015, 0.03), rng.uniform(0.06, 0.12)
    solid = box((length, depth, thick)) + box((thick, depth, height))
    return model_of_solid(
        'tee', solid, {'length': length, 'height': height, 'depth': depth}, density=WOOD
    )


def make_cross(rng: np.random.Generator) -> ObjectModel:
    """Plus-shaped block."""
    length, arm = rng.uniform(0.08, 0.15), rng.uniform(0.025, 0.05)
    height = rng.uniform(0.025, 0.09)
    solid = box((length, arm, height)) + box((arm, length, height))
    return model_of_solid(
        'cross', solid, {'length': length, 'arm': arm, 'height': height}, density=PLASTIC
    )


def make_stairs(rng: np.random.Generator) -> ObjectModel:
    """Block with two steps."""
    length, height = rng.uniform(0.09, 0.16), rng.uniform(0.07, 0.12)
    depth, step = rng.uniform(0.06, 0.12), rng.uniform(0.35, 0.6)
    outline = [(0, 0), (length, 0), (length, step * height), (step * length, step * height)]
    outline += [(step * length, height), (0, height)]
    return model_of_solid(
        'stairs',
        prism(outline, depth),
        {'length': length, 'height': height, 'depth': depth},
        density=WOOD,
    )


def make_hexagon(rng: np.random.Generator) -> ObjectModel:
    """Prism with five to eight sides: a pencil box, a gift box."""
    radius, height = rng.uniform(0.035, 0.065), rng.uniform(0.04, 0.14)
    sides = int(rng.integers(5, 9))
    return model_of_solid(
        'hexagon',
        Manifold.cylinder(height, radius, radius, sides),
        {'radius': radius, 'height': height},
        density=WOOD,
    )


def make_pyramid(rng: np.random.Generator) -> ObjectModel:
    """Blunt pyramid or cone."""
    radius, height = rng.uniform(0.045, 0.08), rng.uniform(0.07, 0.14)
    sides = int(rng.choice([4, 32]))
    top = radius * rng.uniform(0.25, 0.6)
    return model_of_solid(
        'pyramid',
        Manifold.cylinder(height, radius, top, sides),
        {'radius': radius, 'top_radius': top, 'height': height},
        density=WOOD,
    )


def make_dome(rng: np.random.Generator) -> ObjectModel:
    """Half an ellipsoid on its flat side, a little cut off on top: a bun, a jelly."""
    radius, height = rng.uniform(0.04, 0.075), rng.uniform(0.035, 0.075)
    angles = np.linspace(0.0, 0.42 * np.pi, 9)
    wall = [(float(radius * np.cos(a)), float(height * np.sin(a))) for a in angles]
    return model_of_solid(
        'dome', solid_of_wall(wall), {'radius': radius, 'height': height}, density=500.0
    )


def make_board(rng: np.random.Generator) -> ObjectModel:
    """Cutting board with a grip hole, or a shelf board."""
    size = (rng.uniform(0.20, 0.34), rng.uniform(0.13, 0.22), rng.uniform(0.012, 0.024))
    solid = rounded_box(size, 0.005)
    if rng.random() < 0.6:
        hole = box((0.018, 0.07, 0.1), bottom=-0.02)
        solid -= hole.translate((size[0] / 2 - 0.025, 0.0, 0.0))
    return model_of_solid('board', solid, dict(zip('xyz', size, strict=True)), density=WOOD)


def make_stool(rng: np.random.Generator) -> ObjectModel:
    """Small bench: a board on two side plates."""
    size = (rng.uniform(0.16, 0.26), rng.uniform(0.09, 0.15), rng.uniform(0.07, 0.13))
    thick = rng.uniform(0.012, 0.02)
    solid = box((size[0], size[1], thick), bottom=size[2] - thick)
    for side in (-1, 1):
        leg = box((thick, size[1] * 0.9, size[2] - thick + 0.001))
        solid += leg.translate((side * 0.38 * size[0], 0, 0))
    return model_of_solid('stool', solid, dict(zip('xyz', size, strict=True)), density=WOOD)


def make_pedestal(rng: np.random.Generator) -> ObjectModel:
    """Round stand: a foot, a stem and a plate; a cake stand."""
    foot, plate = rng.uniform(0.04, 0.06), rng.uniform(0.06, 0.12)
    height, stem = rng.uniform(0.07, 0.13), rng.uniform(0.010, 0.018)
    section = [(0.0, 0.0), (foot, 0.0), (foot, 0.008), (stem, 0.018), (stem, height - 0.02)]
    section += [(plate, height - 0.010), (plate, height), (0.0, height)]
    return model_of_solid(
        'pedestal',
        revolve(section),
        {'foot_radius': foot, 'plate_radius': plate, 'height': height},
        density=WOOD,
    )


def make_frame(rng: np.random.Generator) -> ObjectModel:
    """Square ring that stands: a picture frame without a picture, an open shelf cube."""
    width, height = rng.uniform(0.10, 0.19), rng.uniform(0.10, 0.19)
    depth, bar = rng.uniform(0.045, 0.11), rng.uniform(0.009, 0.016)
    hole = box((width - 2 * bar, 2 * depth, height - 2 * bar), bottom=bar)
    return model_of_solid(
        'frame',
        box((width, depth, height)) - hole,
        {'width': width, 'height': height, 'depth': depth, 'bar': bar},
        density=WOOD,
    )
