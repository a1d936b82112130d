"""Closed things and square containers: boxes, cans, bottles, trays, ..."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold

from spatial_relations_ros.datasets.objects.materials import FILLED, PAPER
from spatial_relations_ros.datasets.objects.model_of_solid import model_of_solid
from spatial_relations_ros.datasets.objects.solids import box, solid_of_wall, tapered_box
from spatial_relations_ros.placement.model import ObjectModel


def make_box(rng: np.random.Generator) -> ObjectModel:
    """Closed package: tea, rice, cereals."""
    size = (rng.uniform(0.06, 0.20), rng.uniform(0.03, 0.09), rng.uniform(0.06, 0.26))
    return model_of_solid('box', box(size), dict(zip('xyz', size, strict=True)), density=FILLED)


def make_can(rng: np.random.Generator) -> ObjectModel:
    """Tin can, from tuna to beer."""
    radius, height = rng.uniform(0.026, 0.052), rng.uniform(0.035, 0.170)
    wall = [(radius * 0.97, 0.0), (radius, 0.003), (radius, height - 0.003)]
    wall += [(radius * 0.97, height)]
    return model_of_solid(
        'can', solid_of_wall(wall), {'radius': radius, 'height': height}, density=1000.0
    )


def make_bottle(rng: np.random.Generator) -> ObjectModel:
    """Round bottle with shoulder, neck and cap."""
    radius, height = rng.uniform(0.026, 0.045), rng.uniform(0.16, 0.30)
    neck = radius * rng.uniform(0.32, 0.5)
    shoulder = height * rng.uniform(0.55, 0.72)
    bend = shoulder + (height - shoulder) * rng.uniform(0.35, 0.6)
    wall = [(radius * 0.95, 0.0), (radius, 0.004), (radius, shoulder)]
    wall += [(0.5 * (radius + neck), 0.45 * shoulder + 0.55 * bend), (neck, bend), (neck, height)]
    return model_of_solid(
        'bottle',
        solid_of_wall(wall),
        {'radius': radius, 'neck_radius': neck, 'height': height},
        density=950.0,
    )


def make_dispenser(rng: np.random.Generator) -> ObjectModel:
    """Flat bottle for shampoo or cleaner, with a cap."""
    width, depth = rng.uniform(0.060, 0.095), rng.uniform(0.032, 0.050)
    height = rng.uniform(0.14, 0.24)
    cap_height = rng.uniform(0.015, 0.03)
    section = depth / 2.0
    body = tapered_box(
        (width, depth), (width * rng.uniform(0.7, 1.0), depth), height, radius=0.8 * section
    )
    cap = Manifold.cylinder(cap_height + 0.005, section * 0.6, section * 0.6, 32)
    return model_of_solid(
        'dispenser',
        body + cap.translate((0.0, 0.0, height - 0.005)),
        {'width': width, 'depth': depth, 'height': height + cap_height},
        density=900.0,
    )


def make_carton(rng: np.random.Generator) -> ObjectModel:
    """Milk carton with a gable top."""
    side, body_height = rng.uniform(0.055, 0.095), rng.uniform(0.12, 0.20)
    roof, fin = side * rng.uniform(0.35, 0.55), rng.uniform(0.012, 0.02)
    body = box((side, side, body_height))
    gable = Manifold.hull_points(
        [(x * side / 2, y * side / 2, body_height) for x in (-1, 1) for y in (-1, 1)]
        + [(x * side / 2, y * 0.002, body_height + roof) for x in (-1, 1) for y in (-1, 1)]
    )
    top = box((side, 0.004, roof + fin - 0.01), bottom=body_height + 0.01)
    return model_of_solid(
        'carton',
        body + gable + top,
        {'side': side, 'height': body_height + roof + fin},
        density=FILLED,
    )


def make_book(rng: np.random.Generator) -> ObjectModel:
    """Closed book that lies."""
    size = (rng.uniform(0.11, 0.21), rng.uniform(0.16, 0.29), rng.uniform(0.012, 0.045))
    cover = 0.0025
    pages = box((size[0] - 0.006, size[1] - 0.008, size[2] - 2 * cover), bottom=cover)
    shell = box(size) - box((size[0], size[1], size[2] - 2 * cover), bottom=cover).translate(
        (0.003, 0.0, 0.0)
    )
    # The pages reach into both covers, so that one body results.
    pages = pages + box((size[0] - 0.007, size[1] - 0.010, size[2] - cover), bottom=cover / 2)
    return model_of_solid(
        'book', shell + pages, dict(zip('xyz', size, strict=True)), density=PAPER
    )
