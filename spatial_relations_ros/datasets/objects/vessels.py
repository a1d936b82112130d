"""Round things that hold something: cups, bowls, pots, ..."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold

from spatial_relations_ros.datasets.objects.materials import CERAMIC, GLASS, METAL, PLASTIC
from spatial_relations_ros.datasets.objects.model_of_solid import model_of_solid
from spatial_relations_ros.datasets.objects.solids import Profile, capsule, loop, vessel_of_wall
from spatial_relations_ros.placement.model import ObjectModel, Opening


def round_opening(wall: Profile, thickness: float, floor_thickness: float) -> Opening:
    """The cavity of a vessel that :func:`vessel_of_wall` made."""
    heights, radii = [z for _, z in wall], [radius for radius, _ in wall]
    floor = heights[0] + floor_thickness
    rim_radius = min(r for r, z in wall if z > 0.6 * heights[-1]) - thickness
    floor_radius = float(np.interp(floor, heights, radii)) - thickness
    return Opening((rim_radius,) * 2, (floor_radius,) * 2, heights[-1], floor, is_round=True)


def curved_wall(
    foot: float, rim: float, height: float, *, power: float, num_steps: int = 9
) -> list[tuple[float, float]]:
    """Outer wall whose radius grows from foot to rim; power above 1 bulges outwards."""
    share = np.linspace(0.0, 1.0, num_steps)
    radii = foot + (rim - foot) * (1.0 - (1.0 - share) ** power)
    return list(zip(radii.tolist(), (share * height).tolist(), strict=True))


def with_ear(
    body: Manifold, cavity: Manifold, wall: Profile, rng: np.random.Generator
) -> Manifold:
    """Adds a cup's handle on the +x side."""
    height = wall[-1][1]
    middle = height * rng.uniform(0.48, 0.58)
    half_height = height * rng.uniform(0.26, 0.36)
    half_width = rng.uniform(0.018, 0.028)
    rod = rng.uniform(0.0035, 0.0055)
    radius = float(np.interp(middle, [z for _, z in wall], [r for r, _ in wall]))
    ear = loop(half_width, half_height, rod, flatness=rng.uniform(1.0, 1.8))
    return body + (ear.translate((radius, 0.0, middle)) - cavity)


def make_mug(rng: np.random.Generator) -> ObjectModel:
    """Straight-walled mug with a handle."""
    radius, height = rng.uniform(0.036, 0.050), rng.uniform(0.080, 0.115)
    thickness = rng.uniform(0.003, 0.005)
    wall = [(radius * rng.uniform(0.90, 0.97), 0.0), (radius, 0.008), (radius, height)]
    body, cavity = vessel_of_wall(wall, thickness=thickness, floor_thickness=0.006)
    return model_of_solid(
        'mug',
        with_ear(body, cavity, wall, rng),
        {'radius': radius, 'height': height, 'thickness': thickness},
        opening=round_opening(wall, thickness, 0.006),
        density=CERAMIC,
    )


def make_cup(rng: np.random.Generator) -> ObjectModel:
    """Low cup that widens towards the rim, with a handle."""
    rim, height = rng.uniform(0.038, 0.055), rng.uniform(0.055, 0.080)
    foot = rim * rng.uniform(0.55, 0.75)
    thickness = rng.uniform(0.003, 0.0045)
    wall = curved_wall(foot, rim, height, power=rng.uniform(1.2, 2.6))
    body, cavity = vessel_of_wall(wall, thickness=thickness, floor_thickness=0.006)
    return model_of_solid(
        'cup',
        with_ear(body, cavity, wall, rng),
        {'rim_radius': rim, 'foot_radius': foot, 'height': height, 'thickness': thickness},
        opening=round_opening(wall, thickness, 0.006),
        density=CERAMIC,
    )


def make_glass(rng: np.random.Generator) -> ObjectModel:
    """Drinking glass, slightly conical."""
    rim, height = rng.uniform(0.030, 0.045), rng.uniform(0.085, 0.160)
    foot = rim * rng.uniform(0.70, 0.98)
    wall = [(foot, 0.0), (rim, height)]
    body, _ = vessel_of_wall(wall, thickness=0.0025, floor_thickness=0.008)
    return model_of_solid(
        'glass',
        body,
        {'rim_radius': rim, 'foot_radius': foot, 'height': height},
        opening=round_opening(wall, 0.0025, 0.008),
        density=GLASS,
    )


def make_bowl(rng: np.random.Generator) -> ObjectModel:
    """Bowl with a round wall and a flat foot."""
    rim, height = rng.uniform(0.060, 0.130), rng.uniform(0.045, 0.095)
    foot = rim * rng.uniform(0.40, 0.62)
    thickness = rng.uniform(0.003, 0.005)
    wall = curved_wall(foot, rim, height, power=rng.uniform(1.3, 2.6))
    body, _ = vessel_of_wall(wall, thickness=thickness, floor_thickness=0.006)
    return model_of_solid(
        'bowl',
        body,
        {'rim_radius': rim, 'foot_radius': foot, 'height': height, 'thickness': thickness},
        opening=round_opening(wall, thickness, 0.006),
        density=CERAMIC,
    )


def make_plate(rng: np.random.Generator) -> ObjectModel:
    """Plate with a flat middle and a raised border."""
    rim, height = rng.uniform(0.075, 0.140), rng.uniform(0.014, 0.028)
    foot = rim * rng.uniform(0.58, 0.75)
    thickness = rng.uniform(0.006, 0.010)
    wall = [(foot, 0.0), (foot + 0.35 * (rim - foot), 0.45 * height), (rim, height)]
    body, _ = vessel_of_wall(wall, thickness=thickness, floor_thickness=0.005)
    return model_of_solid(
        'plate',
        body,
        {'rim_radius': rim, 'foot_radius': foot, 'height': height},
        opening=round_opening(wall, thickness, 0.005),
        density=CERAMIC,
    )


def make_pot(rng: np.random.Generator) -> ObjectModel:
    """Cooking pot with two handles."""
    radius, height = rng.uniform(0.075, 0.125), rng.uniform(0.070, 0.150)
    wall = [(radius * 0.96, 0.0), (radius, 0.01), (radius, height)]
    body, cavity = vessel_of_wall(wall, thickness=0.0035, floor_thickness=0.005)
    rod = rng.uniform(0.004, 0.006)
    grip = loop(rng.uniform(0.025, 0.035), rng.uniform(0.030, 0.045), rod)
    grip = grip.rotate((90.0, 0.0, 0.0))
    level = height * rng.uniform(0.65, 0.88)
    ears = grip.translate((radius, 0.0, level)) + grip.translate((-radius, 0.0, level))
    return model_of_solid(
        'pot',
        body + (ears - cavity),
        {'radius': radius, 'height': height},
        opening=round_opening(wall, 0.0035, 0.005),
        density=METAL,
    )


def make_pan(rng: np.random.Generator) -> ObjectModel:
    """Frying pan with one long handle."""
    rim, height = rng.uniform(0.080, 0.130), rng.uniform(0.036, 0.060)
    foot = rim * rng.uniform(0.78, 0.9)
    wall = [(foot, 0.0), (rim, height)]
    body, cavity = vessel_of_wall(wall, thickness=0.004, floor_thickness=0.005)
    length, rod = rng.uniform(0.11, 0.17), rng.uniform(0.006, 0.009)
    level = height * rng.uniform(0.6, 0.75)
    grip = capsule((rim - 0.012, 0.0, level), (rim + length, 0.0, level + 0.01), rod)
    return model_of_solid(
        'pan',
        body + (grip - cavity),
        {'rim_radius': rim, 'height': height, 'handle_length': length},
        opening=round_opening(wall, 0.004, 0.005),
        density=METAL,
    )


def make_bucket(rng: np.random.Generator) -> ObjectModel:
    """Bucket or waste-paper bin without a bail."""
    rim, height = rng.uniform(0.080, 0.120), rng.uniform(0.120, 0.220)
    foot = rim * rng.uniform(0.70, 0.92)
    wall = [(foot, 0.0), (rim, height)]
    body, _ = vessel_of_wall(wall, thickness=0.003, floor_thickness=0.004)
    return model_of_solid(
        'bucket',
        body,
        {'rim_radius': rim, 'foot_radius': foot, 'height': height},
        opening=round_opening(wall, 0.003, 0.004),
        density=PLASTIC,
    )


def make_vase(rng: np.random.Generator) -> ObjectModel:
    """Open vase with a belly."""
    belly, height = rng.uniform(0.035, 0.065), rng.uniform(0.13, 0.24)
    foot, neck = belly * rng.uniform(0.55, 0.8), belly * rng.uniform(0.5, 0.85)
    share = np.linspace(0.0, 1.0, 11)
    radii = np.interp(share, [0.0, 0.4, 0.8, 1.0], [foot, belly, neck, neck * 1.15])
    radii[1:-1] = (radii[:-2] + 2.0 * radii[1:-1] + radii[2:]) / 4.0
    wall = list(zip(radii.tolist(), (share * height).tolist(), strict=True))
    body, _ = vessel_of_wall(wall, thickness=0.004, floor_thickness=0.008)
    return model_of_solid(
        'vase',
        body,
        {'belly_radius': belly, 'foot_radius': foot, 'neck_radius': neck, 'height': height},
        opening=round_opening(wall, 0.004, 0.008),
        density=CERAMIC,
    )


def make_jar(rng: np.random.Generator) -> ObjectModel:
    """Open jar with a short, narrower neck."""
    radius, height = rng.uniform(0.030, 0.055), rng.uniform(0.080, 0.160)
    neck = radius * rng.uniform(0.75, 0.92)
    shoulder = height - rng.uniform(0.015, 0.025)
    wall = [(radius * 0.94, 0.0), (radius, 0.006), (radius, shoulder - 0.008)]
    wall += [(neck, shoulder), (neck, height)]
    body, _ = vessel_of_wall(wall, thickness=0.003, floor_thickness=0.006)
    return model_of_solid(
        'jar',
        body,
        {'radius': radius, 'neck_radius': neck, 'height': height},
        opening=round_opening(wall, 0.003, 0.006),
        density=GLASS,
    )
