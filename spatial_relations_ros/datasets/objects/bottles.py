"""Bottles, cleaners, sprayers and pots with spouts."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold

from spatial_relations_ros.datasets.objects.materials import CERAMIC, GLASS, METAL
from spatial_relations_ros.datasets.objects.model_of_solid import model_of_solid
from spatial_relations_ros.datasets.objects.solids import (
    ball,
    box,
    loop,
    oval,
    rod_through,
    rounded_box,
    solid_of_wall,
    tapered_box,
)
from spatial_relations_ros.datasets.objects.vessels import curved_wall
from spatial_relations_ros.placement.model import ObjectModel

BOTTLED = 950.0


def make_oil_bottle(rng: np.random.Generator) -> ObjectModel:
    """Square bottle with a round neck."""
    side, height = rng.uniform(0.052, 0.075), rng.uniform(0.20, 0.31)
    shoulder, neck = height * rng.uniform(0.55, 0.7), rng.uniform(0.011, 0.016)
    body = tapered_box((side, side), (side, side), shoulder, radius=0.010)
    bend = shoulder + rng.uniform(0.025, 0.05)
    slope = Manifold.batch_hull(
        [
            tapered_box((side, side), (side, side), 0.001, radius=0.010).translate(
                (0, 0, shoulder - 0.001)
            ),
            Manifold.cylinder(0.001, neck, neck, 24).translate((0, 0, bend)),
        ]
    )
    top = Manifold.cylinder(height - bend + 0.002, neck, neck, 24).translate((0, 0, bend - 0.002))
    return model_of_solid(
        'oilbottle', body + slope + top, {'side': side, 'height': height}, density=BOTTLED
    )


def make_shampoo(rng: np.random.Generator) -> ObjectModel:
    """Oval bottle with shoulders and a flat cap."""
    width, depth = rng.uniform(0.060, 0.090), rng.uniform(0.036, 0.052)
    height, cap = rng.uniform(0.15, 0.23), rng.uniform(0.02, 0.035)
    body = oval(width, depth, 0.7 * height)
    shoulder = oval(width, depth, 0.3 * height - cap, top_share=rng.uniform(0.45, 0.8))
    lid = oval(width * 0.5, depth * 0.75, cap + 0.004)
    solid = body + shoulder.translate((0, 0, 0.7 * height - 0.0005))
    solid += lid.translate((0, 0, height - cap - 0.004))
    return model_of_solid(
        'shampoo',
        solid,
        {'width': width, 'depth': depth, 'height': height},
        density=BOTTLED,
    )


def make_cleaner(rng: np.random.Generator) -> ObjectModel:
    """Cleaner bottle with a grip hole at its shoulder."""
    width, depth = rng.uniform(0.085, 0.115), rng.uniform(0.050, 0.070)
    height = rng.uniform(0.22, 0.29)
    shape = Manifold.batch_hull(
        [
            rounded_box((width, depth, 0.6 * height), 0.012),
            rounded_box((width * 0.4, depth * 0.7, 0.05), 0.010).translate(
                (-0.25 * width, 0, 0.85 * height - 0.05)
            ),
        ]
    )
    hole = box((0.024, 2 * depth, 0.055)).rotate((0.0, -18.0, 0.0))
    hole = hole.translate((0.17 * width, 0.0, 0.52 * height))
    neck = Manifold.cylinder(0.16 * height, 0.016, 0.014, 24)
    neck = neck.translate((-0.25 * width, 0, 0.84 * height))
    return model_of_solid(
        'cleaner',
        shape - hole + neck,
        {'width': width, 'depth': depth, 'height': height},
        density=BOTTLED,
    )


def make_sprayer(rng: np.random.Generator) -> ObjectModel:
    """Spray bottle with a trigger head."""
    width, depth = rng.uniform(0.065, 0.090), rng.uniform(0.045, 0.062)
    body, head = rng.uniform(0.13, 0.17), rng.uniform(0.07, 0.10)
    solid = oval(width, depth, 0.65 * body)
    upper = oval(width, depth, 0.35 * body, top_share=0.42)
    solid += upper.translate((0, 0, 0.65 * body - 0.0005))
    solid += Manifold.cylinder(0.035, 0.013, 0.013, 20).translate((0, 0, body - 0.005))
    solid += rounded_box((head, 0.028, 0.030), 0.006).translate((-0.2 * head, 0, body + 0.026))
    lever = rod_through(
        [(-0.35 * head, 0, body + 0.03), (-0.42 * head, 0, body - 0.012)], [0.006, 0.005]
    )
    return model_of_solid(
        'sprayer',
        solid + lever,
        {'width': width, 'depth': depth, 'height': body + 0.056},
        density=BOTTLED,
    )


def make_soap_pump(rng: np.random.Generator) -> ObjectModel:
    """Soap bottle with a pump."""
    radius, height = rng.uniform(0.028, 0.038), rng.uniform(0.10, 0.14)
    wall = [(radius, 0.0), (radius, 0.8 * height), (0.014, height), (0.014, height + 0.012)]
    wall += [(0.006, height + 0.014), (0.006, height + 0.045)]
    head = rounded_box((0.05, 0.018, 0.012), 0.004).translate((-0.016, 0, height + 0.038))
    return model_of_solid(
        'soappump',
        solid_of_wall(wall) + head,
        {'radius': radius, 'height': height + 0.05},
        density=BOTTLED,
    )


def make_wine_bottle(rng: np.random.Generator) -> ObjectModel:
    """Slender bottle with steep shoulders."""
    radius, height = rng.uniform(0.034, 0.041), rng.uniform(0.26, 0.32)
    shoulder, neck = height * rng.uniform(0.55, 0.65), rng.uniform(0.013, 0.016)
    wall = [(radius, 0.0), (radius, shoulder), (0.75 * radius, shoulder + 0.035)]
    wall += [(neck, shoulder + 0.055), (neck, height - 0.02), (neck + 0.002, height - 0.019)]
    wall += [(neck + 0.002, height)]
    return model_of_solid(
        'winebottle',
        solid_of_wall(wall),
        {'radius': radius, 'height': height},
        density=GLASS / 2,
    )


def make_honey_bottle(rng: np.random.Generator) -> ObjectModel:
    """Waisted squeeze bottle with a conical cap."""
    radius, height = rng.uniform(0.028, 0.040), rng.uniform(0.12, 0.19)
    waist = radius * rng.uniform(0.7, 0.85)
    wall = [(radius, 0.0), (radius, 0.2 * height), (waist, 0.42 * height)]
    wall += [(radius * 0.95, 0.6 * height), (radius * 0.8, 0.75 * height)]
    wall += [(radius * 0.5, 0.8 * height), (0.008, height)]
    return model_of_solid(
        'honeybottle',
        solid_of_wall(wall),
        {'radius': radius, 'height': height},
        density=BOTTLED,
    )


def make_teapot(rng: np.random.Generator) -> ObjectModel:
    """Teapot with lid, spout and handle."""
    radius, height = rng.uniform(0.055, 0.080), rng.uniform(0.085, 0.125)
    low, high = curved_wall(0.55, 1.0, 0.5, power=2.4), curved_wall(1.0, 0.45, 0.5, power=0.45)
    wall = [(r * radius, z * height) for r, z in low]
    wall += [(r * radius, (0.5 + z) * height) for r, z in high[1:]]
    wall += [(0.25 * radius, 1.06 * height), (0.008, 1.1 * height)]
    knob = ball((0, 0, 1.13 * height), (0.011, 0.011, 0.011))
    reach = radius + rng.uniform(0.035, 0.055)
    spout = rod_through(
        [
            (0.7 * radius, 0, 0.35 * height),
            (radius + 0.4 * (reach - radius), 0, 0.55 * height),
            (reach, 0, 0.95 * height),
        ],
        [0.018, 0.012, 0.007],
    )
    ear = loop(rng.uniform(0.028, 0.038), 0.34 * height, 0.006)
    ear = ear.translate((-0.92 * radius, 0, 0.52 * height))
    return model_of_solid(
        'teapot',
        solid_of_wall(wall) + knob + spout + ear,
        {'radius': radius, 'height': height},
        density=CERAMIC / 2,
    )


def make_kettle(rng: np.random.Generator) -> ObjectModel:
    """Kettle with a bow handle over its top."""
    radius, height = rng.uniform(0.070, 0.090), rng.uniform(0.10, 0.14)
    wall = [(radius, 0.0), (radius, 0.5 * height), (0.6 * radius, 0.9 * height)]
    wall += [(0.4 * radius, height)]
    bow, side = rng.uniform(0.05, 0.07), 0.7 * radius
    arch = rod_through(
        [
            (-side, 0, 0.75 * height),
            (-0.8 * side, 0, height + 0.8 * bow),
            (0, 0, height + bow),
            (0.8 * side, 0, height + 0.8 * bow),
            (side, 0, 0.75 * height),
        ],
        [0.006] * 5,
    )
    spout = rod_through(
        [(0.8 * radius, 0, 0.4 * height), (radius + 0.045, 0, 0.85 * height)], [0.016, 0.009]
    )
    return model_of_solid(
        'kettle',
        solid_of_wall(wall) + arch + spout,
        {'radius': radius, 'height': height + bow},
        density=METAL / 4,
    )
