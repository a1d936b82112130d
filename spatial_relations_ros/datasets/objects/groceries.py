"""Things from a kitchen shelf: tins, packs, pouches, tubes, closed jars."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold

from spatial_relations_ros.datasets.objects.materials import CERAMIC, FILLED, GLASS, PLASTIC
from spatial_relations_ros.datasets.objects.model_of_solid import model_of_solid
from spatial_relations_ros.datasets.objects.solids import (
    ball,
    box,
    oval,
    rounded_box,
    solid_of_wall,
)
from spatial_relations_ros.datasets.objects.vessels import curved_wall
from spatial_relations_ros.placement.model import ObjectModel


def _block(
    family: str,
    rng: np.random.Generator,
    *,
    x: tuple[float, float],
    y: tuple[float, float],
    z: tuple[float, float],
    density: float = FILLED,
) -> ObjectModel:
    size = (rng.uniform(*x), rng.uniform(*y), rng.uniform(*z))
    return model_of_solid(family, box(size), dict(zip('xyz', size, strict=True)), density=density)


def make_tea_box(rng: np.random.Generator) -> ObjectModel:
    """Pack of tea bags: a small, flat-sided carton."""
    return _block('teabox', rng, x=(0.10, 0.16), y=(0.05, 0.08), z=(0.06, 0.09))


def make_muesli(rng: np.random.Generator) -> ObjectModel:
    """Large cereal carton, tall and thin."""
    return _block('muesli', rng, x=(0.14, 0.21), y=(0.05, 0.08), z=(0.20, 0.30))


def make_gum_pack(rng: np.random.Generator) -> ObjectModel:
    """Small flat pack: chewing gum, cards, matches."""
    return _block('gumpack', rng, x=(0.055, 0.10), y=(0.035, 0.07), z=(0.014, 0.028))


def make_butter(rng: np.random.Generator) -> ObjectModel:
    """Bar: butter, soap, a sponge."""
    size = (rng.uniform(0.075, 0.12), rng.uniform(0.045, 0.075), rng.uniform(0.025, 0.045))
    return model_of_solid(
        'butter',
        rounded_box(size, rng.uniform(0.002, 0.010)),
        dict(zip('xyz', size, strict=True)),
        density=900.0,
    )


def make_tuna(rng: np.random.Generator) -> ObjectModel:
    """Flat tin with a raised rim at both ends."""
    radius, height = rng.uniform(0.034, 0.050), rng.uniform(0.030, 0.048)
    wall = [(radius, 0.0), (radius, 0.003), (radius - 0.002, 0.005)]
    wall += [(radius - 0.002, height - 0.005), (radius, height - 0.003), (radius, height)]
    return model_of_solid(
        'tuna', solid_of_wall(wall), {'radius': radius, 'height': height}, density=1000.0
    )


def make_coffee_tin(rng: np.random.Generator) -> ObjectModel:
    """Round tin with a plastic lid that is a little wider."""
    radius, height = rng.uniform(0.038, 0.060), rng.uniform(0.085, 0.165)
    lid = rng.uniform(0.010, 0.020)
    wall = [(radius, 0.0), (radius, height - lid), (radius + 0.0025, height - lid + 0.001)]
    wall += [(radius + 0.0025, height - 0.002), (radius, height)]
    return model_of_solid(
        'coffeetin', solid_of_wall(wall), {'radius': radius, 'height': height}, density=FILLED
    )


def make_chips_can(rng: np.random.Generator) -> ObjectModel:
    """Long, slender tube: crisps, a poster tube's piece."""
    radius, height = rng.uniform(0.026, 0.040), rng.uniform(0.17, 0.27)
    wall = [(radius, 0.0), (radius, height - 0.012), (radius + 0.002, height - 0.011)]
    wall += [(radius + 0.002, height)]
    return model_of_solid(
        'chipscan', solid_of_wall(wall), {'radius': radius, 'height': height}, density=300.0
    )


def make_oval_tin(rng: np.random.Generator) -> ObjectModel:
    """Tin on an oval, like herring or sweets come in."""
    size = (rng.uniform(0.09, 0.15), rng.uniform(0.055, 0.085), rng.uniform(0.022, 0.06))
    return model_of_solid(
        'ovaltin', oval(*size), dict(zip('xyz', size, strict=True)), density=900.0
    )


def make_pouch(rng: np.random.Generator) -> ObjectModel:
    """Bag of salt, sugar or rice: soft sides, a folded, narrower top."""
    width, depth = rng.uniform(0.07, 0.12), rng.uniform(0.045, 0.075)
    height, fold = rng.uniform(0.10, 0.19), rng.uniform(0.015, 0.03)
    body = Manifold.batch_hull(
        [
            rounded_box((width, depth, 0.03), 0.006),
            rounded_box((width * 1.03, depth * 1.1, 0.04), 0.015).translate((0, 0, 0.4 * height)),
            box((width * 0.92, depth * rng.uniform(0.3, 0.6), 0.005), bottom=height - 0.005),
        ]
    )
    flap = box((width * 0.9, 0.010, fold + 0.004), bottom=height - 0.004)
    return model_of_solid(
        'pouch', body + flap, {'width': width, 'depth': depth, 'height': height}, density=FILLED
    )


def make_flat_bag(rng: np.random.Generator) -> ObjectModel:
    """Filled bag that lies: a cushion of rice or beans."""
    size = (rng.uniform(0.11, 0.18), rng.uniform(0.08, 0.12), rng.uniform(0.03, 0.055))
    middle = box((size[0] * 0.55, size[1] * 0.55, size[2]))
    seam = box((size[0], size[1] * 0.9, 0.006), bottom=0.42 * size[2])
    return model_of_solid(
        'flatbag',
        Manifold.batch_hull([middle, seam]),
        dict(zip('xyz', size, strict=True)),
        density=FILLED,
    )


def make_tube(rng: np.random.Generator) -> ObjectModel:
    """Tube that stands on its cap: tooth paste, mustard, cream."""
    radius, height = rng.uniform(0.018, 0.026), rng.uniform(0.11, 0.18)
    cap = rng.uniform(0.018, 0.028)
    body = Manifold.batch_hull(
        [
            Manifold.cylinder(0.004, radius, radius, 32).translate((0, 0, cap)),
            box((3.1 * radius, 0.005, 0.012), bottom=height - 0.012),
        ]
    )
    foot = Manifold.cylinder(cap + 0.003, radius * 0.92, radius * 0.86, 32)
    return model_of_solid(
        'tube', body + foot, {'radius': radius, 'height': height}, density=1000.0
    )


def make_closed_jar(rng: np.random.Generator) -> ObjectModel:
    """Jar with its lid on: jam, pickles."""
    radius, height = rng.uniform(0.030, 0.048), rng.uniform(0.075, 0.150)
    neck, lid = radius * rng.uniform(0.78, 0.92), rng.uniform(0.012, 0.020)
    wall = [(radius * 0.95, 0.0), (radius, 0.005), (radius, height - lid - 0.018)]
    wall += [(neck, height - lid - 0.003), (neck + 0.003, height - lid), (neck + 0.003, height)]
    return model_of_solid(
        'closedjar', solid_of_wall(wall), {'radius': radius, 'height': height}, density=GLASS / 2
    )


def make_spice_jar(rng: np.random.Generator) -> ObjectModel:
    """Small shaker for salt, pepper or spices."""
    radius, height = rng.uniform(0.017, 0.026), rng.uniform(0.065, 0.115)
    wall = [(radius, 0.0), (radius * rng.uniform(0.75, 1.0), 0.7 * height)]
    wall += [(radius * 0.9, 0.72 * height), (radius * 0.9, 0.93 * height), (radius * 0.6, height)]
    return model_of_solid(
        'spicejar', solid_of_wall(wall), {'radius': radius, 'height': height}, density=1200.0
    )


def make_sweetener(rng: np.random.Generator) -> ObjectModel:
    """Sweetener dispenser: a small upright oval with a press button."""
    width, depth = rng.uniform(0.035, 0.055), rng.uniform(0.016, 0.026)
    height = rng.uniform(0.06, 0.10)
    body = oval(width, depth, height, top_share=rng.uniform(0.75, 1.0))
    button = box((width * 0.4, depth * 0.5, 0.009), bottom=height - 0.003)
    return model_of_solid(
        'sweetener',
        body + button,
        {'width': width, 'depth': depth, 'height': height},
        density=PLASTIC,
    )


def make_sugar_bowl(rng: np.random.Generator) -> ObjectModel:
    """Sugar bowl with its lid on and a knob on top."""
    radius, height = rng.uniform(0.040, 0.060), rng.uniform(0.055, 0.085)
    foot, knob = radius * rng.uniform(0.5, 0.7), rng.uniform(0.008, 0.013)
    lid = rng.uniform(0.012, 0.025)
    wall = curved_wall(foot, radius, height, power=rng.uniform(1.5, 2.6))
    wall += [(radius * 0.95, height + 0.002), (radius * 0.5, height + lid * 0.8)]
    wall += [(0.006, height + lid), (0.006, height + lid + 0.004)]
    top = ball((0.0, 0.0, height + lid + 0.6 * knob), (knob, knob, knob))
    return model_of_solid(
        'sugarbowl',
        solid_of_wall(wall) + top,
        {'radius': radius, 'height': height + lid + 1.6 * knob},
        density=CERAMIC / 2,
    )


def make_egg_box(rng: np.random.Generator) -> ObjectModel:
    """Closed egg carton with sloping sides."""
    size = (rng.uniform(0.14, 0.24), rng.uniform(0.095, 0.115), rng.uniform(0.06, 0.07))
    band = box((size[0], size[1], 0.006), bottom=0.45 * size[2])
    middle = box((size[0] * 0.9, size[1] * 0.82, size[2]))
    solid = Manifold.batch_hull([band, middle])
    return model_of_solid('eggbox', solid, dict(zip('xyz', size, strict=True)), density=400.0)
