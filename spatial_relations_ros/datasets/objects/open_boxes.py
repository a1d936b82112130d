"""Boxes without a lid: containers, drawers, baskets, trays, shallow lids."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold

from spatial_relations_ros.datasets.objects.materials import CARDBOARD, CERAMIC, PLASTIC, WOOD
from spatial_relations_ros.datasets.objects.model_of_solid import model_of_solid
from spatial_relations_ros.datasets.objects.solids import box, tapered_box
from spatial_relations_ros.placement.model import ObjectModel, Opening


def _square_vessel(
    family: str,
    bottom: tuple[float, float],
    top: tuple[float, float],
    height: float,
    *,
    wall: float,
    radius: float,
    density: float,
    extra: Manifold | None = None,
) -> ObjectModel:
    outer = tapered_box(bottom, top, height, radius=radius)
    inner_bottom = (bottom[0] - 2 * wall, bottom[1] - 2 * wall)
    inner_top = (top[0] - 2 * wall, top[1] - 2 * wall)
    cavity = tapered_box(inner_bottom, inner_top, height, radius=max(radius - wall, 0.0))
    above = tapered_box(inner_top, inner_top, 0.05, radius=max(radius - wall, 0.0))
    cavity = cavity.translate((0, 0, wall)) + above.translate((0, 0, height))
    opening = Opening(
        (inner_top[0] / 2, inner_top[1] / 2),
        (inner_bottom[0] / 2, inner_bottom[1] / 2),
        height,
        wall,
        is_round=False,
    )
    dimensions = {'top_x': top[0], 'top_y': top[1], 'height': height, 'wall': wall}
    solid = outer if extra is None else outer + extra
    return model_of_solid(family, solid - cavity, dimensions, opening=opening, density=density)


def make_container(rng: np.random.Generator) -> ObjectModel:
    """Box without a lid, straight walls."""
    size = (rng.uniform(0.11, 0.26), rng.uniform(0.09, 0.19))
    return _square_vessel(
        'container',
        size,
        size,
        rng.uniform(0.06, 0.14),
        wall=rng.uniform(0.003, 0.006),
        radius=0.0,
        density=PLASTIC,
    )


def make_basket(rng: np.random.Generator) -> ObjectModel:
    """Basket: walls that lean outwards, round corners."""
    top = (rng.uniform(0.16, 0.27), rng.uniform(0.13, 0.20))
    share = rng.uniform(0.72, 0.9)
    return _square_vessel(
        'basket',
        (top[0] * share, top[1] * share),
        top,
        rng.uniform(0.07, 0.15),
        wall=0.005,
        radius=rng.uniform(0.015, 0.035),
        density=WOOD,
    )


def make_drawer(rng: np.random.Generator) -> ObjectModel:
    """Deep, small box without a lid: a drawer, a desk organiser, a pen holder."""
    size = (rng.uniform(0.07, 0.13), rng.uniform(0.07, 0.11))
    return _square_vessel(
        'drawer',
        size,
        size,
        rng.uniform(0.09, 0.15),
        wall=rng.uniform(0.003, 0.006),
        radius=0.0,
        density=WOOD,
    )


def make_tray(rng: np.random.Generator) -> ObjectModel:
    """Flat tray or the lid of a box."""
    top = (rng.uniform(0.15, 0.30), rng.uniform(0.11, 0.22))
    share = rng.uniform(0.88, 1.0)
    return _square_vessel(
        'tray',
        (top[0] * share, top[1] * share),
        top,
        rng.uniform(0.018, 0.034),
        wall=0.004,
        radius=rng.uniform(0.0, 0.02),
        density=WOOD,
    )


def _straight(
    family: str,
    rng: np.random.Generator,
    *,
    x: tuple[float, float],
    y: tuple[float, float],
    height: tuple[float, float],
    wall: tuple[float, float],
    density: float,
) -> ObjectModel:
    size = (rng.uniform(*x), rng.uniform(*y))
    thickness = rng.uniform(*wall)
    return _square_vessel(
        family,
        size,
        size,
        rng.uniform(*height),
        wall=thickness,
        radius=0.0,
        density=density,
    )


def make_box_base(rng: np.random.Generator) -> ObjectModel:
    """Cardboard storage box whose lid is off."""
    return _straight(
        'boxbase',
        rng,
        x=(0.14, 0.28),
        y=(0.12, 0.22),
        height=(0.09, 0.17),
        wall=(0.003, 0.006),
        density=CARDBOARD,
    )


def make_box_lid(rng: np.random.Generator) -> ObjectModel:
    """Shallow lid of a storage box, lying with its hollow up."""
    return _straight(
        'boxlid',
        rng,
        x=(0.11, 0.28),
        y=(0.10, 0.21),
        height=(0.018, 0.034),
        wall=(0.003, 0.005),
        density=CARDBOARD,
    )


def make_deep_lid(rng: np.random.Generator) -> ObjectModel:
    """Deep lid, or a low box."""
    return _straight(
        'deeplid',
        rng,
        x=(0.12, 0.26),
        y=(0.11, 0.20),
        height=(0.050, 0.085),
        wall=(0.003, 0.006),
        density=CARDBOARD,
    )


def make_shelf_drawer(rng: np.random.Generator) -> ObjectModel:
    """Large drawer of a shelf: a wide open box."""
    return _straight(
        'shelfdrawer',
        rng,
        x=(0.28, 0.39),
        y=(0.22, 0.34),
        height=(0.10, 0.17),
        wall=(0.006, 0.012),
        density=WOOD,
    )


def make_baking_dish(rng: np.random.Generator) -> ObjectModel:
    """Baking dish with a grip on each side."""
    top = (rng.uniform(0.18, 0.28), rng.uniform(0.12, 0.19))
    share, height = rng.uniform(0.85, 0.95), rng.uniform(0.048, 0.075)
    grip = box((top[0] + rng.uniform(0.03, 0.05), top[1] * 0.5, 0.010), bottom=height - 0.016)
    return _square_vessel(
        'bakingdish',
        (top[0] * share, top[1] * share),
        top,
        height,
        wall=0.006,
        radius=0.02,
        density=CERAMIC,
        extra=grip,
    )


def make_crate(rng: np.random.Generator) -> ObjectModel:
    """Wooden crate: open box with strips around it."""
    size = (rng.uniform(0.18, 0.28), rng.uniform(0.13, 0.20))
    height, strip = rng.uniform(0.09, 0.15), rng.uniform(0.004, 0.008)
    band = (size[0] + 2 * strip, size[1] + 2 * strip, rng.uniform(0.015, 0.03))
    low = box(band, bottom=0.15 * height)
    high = box(band, bottom=height - band[2])
    return _square_vessel(
        'crate',
        size,
        size,
        height,
        wall=rng.uniform(0.006, 0.010),
        radius=0.0,
        density=WOOD,
        extra=low + high,
    )


def make_square_bowl(rng: np.random.Generator) -> ObjectModel:
    """Square bowl with round corners."""
    top, share = rng.uniform(0.11, 0.19), rng.uniform(0.6, 0.8)
    return _square_vessel(
        'squarebowl',
        (top * share, top * share),
        (top, top),
        rng.uniform(0.05, 0.085),
        wall=0.005,
        radius=0.015,
        density=CERAMIC,
    )
