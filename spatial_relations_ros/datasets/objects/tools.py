"""Tools and gadgets; they lie in their natural rest."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold

from spatial_relations_ros.datasets.objects.materials import METAL, PLASTIC, WOOD
from spatial_relations_ros.datasets.objects.model_of_solid import model_of_solid
from spatial_relations_ros.datasets.objects.solids import (
    ball,
    box,
    flat_below,
    loop,
    rod_through,
    rounded_box,
)
from spatial_relations_ros.placement.model import ObjectModel


def make_hammer(rng: np.random.Generator) -> ObjectModel:
    """Hammer or mallet."""
    length, head = rng.uniform(0.20, 0.28), rng.uniform(0.07, 0.11)
    thick = rng.uniform(0.024, 0.04)
    grip = rounded_box((length, 0.022, 0.022), 0.006).translate((0.5 * length, 0, 0))
    block = rounded_box((thick, head, thick), 0.003)
    return model_of_solid(
        'hammer', grip + block, {'length': length, 'head': head}, density=METAL / 3
    )


def make_spoon(rng: np.random.Generator) -> ObjectModel:
    """Cooking spoon or ladle."""
    length, bowl = rng.uniform(0.20, 0.29), rng.uniform(0.024, 0.036)
    grip = rod_through([(0.0, 0.0, 0.009), (length, 0.0, 0.009)], [0.007, 0.008])
    disc = ball((0, 0, 0.011), (1.4 * bowl, bowl, 0.012))
    hollow = ball((0, 0, 0.028), (1.2 * bowl, 0.8 * bowl, 0.018))
    return model_of_solid(
        'spoon',
        flat_below(grip + disc - hollow, 0.003),
        {'length': length, 'bowl': bowl},
        density=WOOD,
    )


def make_brush(rng: np.random.Generator) -> ObjectModel:
    """Scrubbing brush with a handle."""
    length, head = rng.uniform(0.18, 0.26), rng.uniform(0.07, 0.10)
    bristles = box((head, 0.045, 0.03))
    back = rounded_box((head + 0.01, 0.055, 0.018), 0.005).translate((0, 0, 0.026))
    grip = rounded_box((length - 0.5 * head, 0.025, 0.016), 0.005)
    grip = grip.translate((0.5 * length, 0, 0.027))
    return model_of_solid(
        'brush', bristles + back + grip, {'length': length, 'head': head}, density=WOOD
    )


def make_torch(rng: np.random.Generator) -> ObjectModel:
    """Torch that stands on its head."""
    head, grip = rng.uniform(0.022, 0.034), rng.uniform(0.013, 0.018)
    length = rng.uniform(0.12, 0.20)
    solid = Manifold.cylinder(0.035, head, head, 32)
    solid += Manifold.cylinder(0.025, head, grip, 32).translate((0, 0, 0.034))
    solid += Manifold.cylinder(length - 0.05, grip, grip, 32).translate((0, 0, 0.05))
    return model_of_solid('torch', solid, {'head': head, 'length': length}, density=1500.0)


def make_rolling_pin(rng: np.random.Generator) -> ObjectModel:
    """Rolling pin with two grips; a dumb-bell when short."""
    radius, length = rng.uniform(0.02, 0.032), rng.uniform(0.10, 0.20)
    grip, rod = rng.uniform(0.035, 0.06), 0.011
    total = Manifold.cylinder(length, radius, radius, 32, True)
    total += Manifold.cylinder(length + 2 * grip, rod, rod, 24, True)
    return model_of_solid(
        'rollingpin',
        flat_below(total.rotate((0.0, 90.0, 0.0)), -radius * 0.97),
        {'radius': radius, 'length': length + 2 * grip},
        density=WOOD,
    )


def make_phone(rng: np.random.Generator) -> ObjectModel:
    """Phone, remote control or wallet: flat with round corners."""
    size = (rng.uniform(0.12, 0.20), rng.uniform(0.045, 0.085), rng.uniform(0.012, 0.026))
    return model_of_solid(
        'phone',
        rounded_box(size, 0.005),
        dict(zip('xyz', size, strict=True)),
        density=1500.0,
    )


def make_mouse(rng: np.random.Generator) -> ObjectModel:
    """Computer mouse: a lump with a flat foot."""
    size = (rng.uniform(0.09, 0.12), rng.uniform(0.055, 0.07), rng.uniform(0.03, 0.042))
    lump = ball((0, 0, 0), (size[0] / 2, size[1] / 2, size[2]))
    return model_of_solid(
        'mouse',
        flat_below(lump, 0.003),
        dict(zip('xyz', size, strict=True)),
        density=PLASTIC,
    )


def make_iron(rng: np.random.Generator) -> ObjectModel:
    """Flat iron with a bow handle."""
    length, width = rng.uniform(0.16, 0.22), rng.uniform(0.075, 0.10)
    height = rng.uniform(0.035, 0.05)
    sole = Manifold.hull_points(
        [
            (x, y * width / 2, z)
            for x in (0.0, 0.5 * length)
            for y in (-1, 1)
            for z in (0.0, height)
        ]
        + [(length, 0.0, 0.0), (0.85 * length, 0.0, height)]
    )
    bow = loop(0.36 * length, rng.uniform(0.04, 0.055), 0.009)
    bow = bow.translate((0.4 * length, 0, height))
    return model_of_solid(
        'iron',
        sole + flat_below(bow, 0.5 * height),
        {'length': length, 'width': width, 'height': height},
        density=1500.0,
    )
