"""More round ware: dishes, cups without a handle, jugs, pans, sieves."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold

from spatial_relations_ros.datasets.objects.materials import CERAMIC, GLASS, METAL, PLASTIC
from spatial_relations_ros.datasets.objects.model_of_solid import model_of_solid
from spatial_relations_ros.datasets.objects.solids import (
    Profile,
    capsule,
    loop,
    revolve,
    rod_through,
    vessel_of_wall,
)
from spatial_relations_ros.datasets.objects.vessels import curved_wall, round_opening, with_ear
from spatial_relations_ros.placement.model import ObjectModel


def _dish(
    family: str,
    wall: Profile,
    *,
    thickness: float,
    floor: float,
    density: float,
    extra: Manifold | None = None,
) -> ObjectModel:
    """A round vessel open at the top, with what is attached outside of it."""
    body, cavity = vessel_of_wall(wall, thickness=thickness, floor_thickness=floor)
    if extra is not None:
        body += extra - cavity
    return model_of_solid(
        family,
        body,
        {'rim_radius': wall[-1][0], 'foot_radius': wall[0][0], 'height': wall[-1][1]},
        opening=round_opening(wall, thickness, floor),
        density=density,
    )


def make_saucer(rng: np.random.Generator) -> ObjectModel:
    """Small plate for a cup."""
    rim, height = rng.uniform(0.058, 0.080), rng.uniform(0.014, 0.022)
    foot = rim * rng.uniform(0.5, 0.65)
    wall = [(foot, 0.0), (foot + 0.4 * (rim - foot), 0.5 * height), (rim, height)]
    return _dish('saucer', wall, thickness=0.006, floor=0.005, density=CERAMIC)


def make_deep_plate(rng: np.random.Generator) -> ObjectModel:
    """Soup plate with a wide, level border."""
    rim, height = rng.uniform(0.095, 0.125), rng.uniform(0.026, 0.034)
    foot, bend = rim * rng.uniform(0.4, 0.5), rim * rng.uniform(0.66, 0.76)
    wall = [(foot, 0.0), (bend, 0.8 * height), (rim, height)]
    return _dish('deepplate', wall, thickness=0.007, floor=0.006, density=CERAMIC)


def make_ramekin(rng: np.random.Generator) -> ObjectModel:
    """Small round baking dish with upright walls."""
    radius, height = rng.uniform(0.042, 0.060), rng.uniform(0.045, 0.065)
    wall = [(radius * 0.95, 0.0), (radius, 0.004), (radius, height)]
    return _dish('ramekin', wall, thickness=0.005, floor=0.006, density=CERAMIC)


def make_footed_bowl(rng: np.random.Generator) -> ObjectModel:
    """Bowl on a ring-shaped foot."""
    rim, height = rng.uniform(0.055, 0.085), rng.uniform(0.05, 0.075)
    foot, base = rim * rng.uniform(0.45, 0.55), rng.uniform(0.008, 0.014)
    belly = curved_wall(foot * 0.85, rim, height - base, power=rng.uniform(1.6, 2.8))
    wall = [(foot, 0.0), (foot * 0.95, 0.8 * base)]
    wall += [(radius, z + base) for radius, z in belly]
    return _dish('footedbowl', wall, thickness=0.004, floor=base + 0.005, density=CERAMIC)


def make_salad_bowl(rng: np.random.Generator) -> ObjectModel:
    """Large, deep bowl."""
    rim, height = rng.uniform(0.11, 0.145), rng.uniform(0.085, 0.125)
    wall = curved_wall(rim * rng.uniform(0.4, 0.55), rim, height, power=rng.uniform(1.6, 2.4))
    return _dish('saladbowl', wall, thickness=0.005, floor=0.006, density=PLASTIC)


def make_beaker(rng: np.random.Generator) -> ObjectModel:
    """Conical paper or plastic cup without a handle."""
    rim, height = rng.uniform(0.036, 0.053), rng.uniform(0.085, 0.140)
    wall = [(rim * rng.uniform(0.52, 0.75), 0.0), (rim, height - 0.004)]
    wall += [(rim + 0.003, height - 0.003), (rim + 0.003, height)]
    return _dish('beaker', wall, thickness=0.0025, floor=0.005, density=PLASTIC)


def make_goblet(rng: np.random.Generator) -> ObjectModel:
    """Glass on a stem and a flat foot."""
    foot, stem = rng.uniform(0.030, 0.038), rng.uniform(0.0045, 0.006)
    low, height = rng.uniform(0.045, 0.075), rng.uniform(0.13, 0.19)
    rim = rng.uniform(0.030, 0.042)
    cup = curved_wall(0.015, rim, height - low, power=rng.uniform(2.0, 3.0))
    wall = [(foot, 0.0), (foot, 0.003), (stem, 0.009), (stem, low - 0.004)]
    wall += [(radius, z + low) for radius, z in cup]
    return _dish('goblet', wall, thickness=0.0025, floor=low + 0.006, density=GLASS)


def make_egg_cup(rng: np.random.Generator) -> ObjectModel:
    """Egg cup: a small bowl on a foot."""
    rim, height = rng.uniform(0.024, 0.030), rng.uniform(0.052, 0.075)
    foot = rim * rng.uniform(0.8, 1.0)
    wall = [(foot, 0.0), (foot, 0.004), (0.010, 0.25 * height), (rim * 0.8, 0.42 * height)]
    wall += [(rim, 0.7 * height), (rim, height)]
    return _dish('eggcup', wall, thickness=0.003, floor=0.36 * height, density=CERAMIC)


def make_jug(rng: np.random.Generator) -> ObjectModel:
    """Jug with a handle and a lip."""
    belly, height = rng.uniform(0.045, 0.065), rng.uniform(0.14, 0.22)
    neck = belly * rng.uniform(0.65, 0.9)
    wall = [(belly * 0.8, 0.0), (belly, 0.35 * height), (neck, 0.8 * height), (neck, height)]
    lip = Manifold.hull_points(
        [(-neck * 0.95, y * 0.018, height) for y in (-1, 1)]
        + [(-neck * 0.95, y * 0.012, height - 0.035) for y in (-1, 1)]
        + [(-neck - rng.uniform(0.015, 0.03), 0.0, height)]
    )
    half = 0.28 * height
    ear = loop(rng.uniform(0.026, 0.036), half, 0.006, flatness=rng.uniform(1.0, 1.6))
    ear = ear.translate((0.5 * (belly + neck) + 0.002, 0.0, 0.58 * height))
    return _dish('jug', wall, thickness=0.004, floor=0.007, density=CERAMIC, extra=lip + ear)


def make_saucepan(rng: np.random.Generator) -> ObjectModel:
    """High pan with one long handle."""
    radius, height = rng.uniform(0.065, 0.095), rng.uniform(0.070, 0.105)
    wall = [(radius * 0.96, 0.0), (radius, 0.008), (radius, height)]
    level, length = height - 0.015, rng.uniform(0.10, 0.15)
    grip = capsule((radius - 0.008, 0.0, level), (radius + length, 0.0, level), 0.008)
    return _dish('saucepan', wall, thickness=0.0035, floor=0.005, density=METAL, extra=grip)


def make_wok(rng: np.random.Generator) -> ObjectModel:
    """Wide pan with curved walls and two small grips."""
    rim, height = rng.uniform(0.12, 0.15), rng.uniform(0.065, 0.09)
    wall = curved_wall(rim * rng.uniform(0.35, 0.45), rim, height, power=rng.uniform(1.5, 2.0))
    grip = loop(0.024, 0.030, 0.0045).rotate((90.0, 0.0, 0.0))
    level = height - 0.008
    grips = grip.translate((rim, 0.0, level)) + grip.translate((-rim, 0.0, level))
    return _dish('wok', wall, thickness=0.004, floor=0.005, density=METAL, extra=grips)


def make_watering_can(rng: np.random.Generator) -> ObjectModel:
    """Open watering can with a spout and a handle."""
    radius, height = rng.uniform(0.055, 0.075), rng.uniform(0.11, 0.16)
    wall = [(radius, 0.0), (radius * rng.uniform(0.85, 1.0), height)]
    tip = radius + rng.uniform(0.08, 0.13)
    spout = rod_through(
        [(radius - 0.01, 0.0, 0.25 * height), (tip, 0.0, height - 0.012)], [0.011, 0.008]
    )
    ear = loop(rng.uniform(0.035, 0.05), 0.34 * height, 0.006).translate(
        (-radius, 0.0, 0.55 * height)
    )
    return _dish(
        'wateringcan', wall, thickness=0.003, floor=0.004, density=PLASTIC, extra=spout + ear
    )


def make_flower_pot(rng: np.random.Generator) -> ObjectModel:
    """Flower pot with a thick rim."""
    rim, height = rng.uniform(0.050, 0.085), rng.uniform(0.085, 0.14)
    foot, lip = rim * rng.uniform(0.6, 0.75), rng.uniform(0.018, 0.028)
    wall = [(foot, 0.0), (rim - 0.006, height - lip), (rim, height - lip + 0.001), (rim, height)]
    return _dish('flowerpot', wall, thickness=0.006, floor=0.007, density=CERAMIC)


def make_espresso_cup(rng: np.random.Generator) -> ObjectModel:
    """Small cup with a handle."""
    rim, height = rng.uniform(0.028, 0.036), rng.uniform(0.048, 0.062)
    wall = curved_wall(rim * rng.uniform(0.65, 0.8), rim, height, power=rng.uniform(1.5, 2.5))
    body, cavity = vessel_of_wall(wall, thickness=0.0035, floor_thickness=0.005)
    return model_of_solid(
        'espresso',
        with_ear(body, cavity, wall, rng),
        {'rim_radius': rim, 'height': height},
        opening=round_opening(wall, 0.0035, 0.005),
        density=CERAMIC,
    )


def make_funnel(rng: np.random.Generator) -> ObjectModel:
    """Funnel that stands on its rim, open at both ends."""
    rim, height = rng.uniform(0.045, 0.070), rng.uniform(0.10, 0.15)
    tube, bend, wall = rng.uniform(0.009, 0.013), rng.uniform(0.45, 0.6) * height, 0.003
    outer = [(rim, 0.0), (rim, 0.006), (tube, bend), (tube * 0.8, height)]
    inner = [(radius - wall, z) for radius, z in outer[::-1]]
    return model_of_solid(
        'funnel',
        revolve([*outer, *inner]),
        {'rim_radius': rim, 'tube_radius': tube, 'height': height},
        density=PLASTIC,
    )


def make_ring(rng: np.random.Generator) -> ObjectModel:
    """Torus: a toy ring, a roll of tape."""
    tube = rng.uniform(0.012, 0.026)
    radius = tube + rng.uniform(0.020, 0.05)
    angles = np.linspace(0.0, 2.0 * np.pi, 20, endpoint=False)
    flat = rng.uniform(0.8, 1.3)
    section = [(radius + tube * np.cos(a), tube * flat * np.sin(a)) for a in angles]
    return model_of_solid(
        'ring',
        revolve(section, num_segments=40),
        {'radius': radius, 'tube': tube},
        density=PLASTIC,
    )


def make_tape(rng: np.random.Generator) -> ObjectModel:
    """Roll of tape or toilet paper: a hollow cylinder."""
    outer = rng.uniform(0.035, 0.058)
    inner, height = outer * rng.uniform(0.4, 0.75), rng.uniform(0.02, 0.10)
    section = [(inner, 0.0), (outer, 0.0), (outer, height), (inner, height)]
    return model_of_solid(
        'tape',
        revolve(section),
        {'outer_radius': outer, 'inner_radius': inner, 'height': height},
        density=PLASTIC,
    )
