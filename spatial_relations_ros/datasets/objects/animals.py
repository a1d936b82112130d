"""Toy animals and lumpy figures that stand on flat feet."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold, OpType

from spatial_relations_ros.datasets.objects.materials import CERAMIC, RUBBER
from spatial_relations_ros.datasets.objects.model_of_solid import model_of_solid
from spatial_relations_ros.datasets.objects.solids import ball, flat_below, rod_through
from spatial_relations_ros.placement.model import ObjectModel


def make_quadruped(rng: np.random.Generator) -> ObjectModel:
    """Dog, horse, cow, dinosaur: a body on four legs, with neck, head and tail."""
    length, height = rng.uniform(0.09, 0.16), rng.uniform(0.04, 0.075)
    girth, leg = rng.uniform(0.016, 0.028), rng.uniform(0.008, 0.012)
    front, back, level = 0.4 * length, -0.4 * length, height + 0.5 * girth
    parts = [rod_through([(back, 0, level), (front, 0, level)], [girth, girth * 0.95])]
    for x in (0.85 * back, 0.85 * front):
        for side in (-1, 1):
            foot = (x * 1.08, side * 0.95 * girth, 0.0)
            parts.append(rod_through([(x, side * 0.5 * girth, level), foot], [leg, leg]))
    top = level + rng.uniform(0.02, 0.07)
    snout = front + rng.uniform(0.035, 0.06)
    neck = [(front, 0, level), (front + 0.018, 0, top), (snout, 0, top - 0.008)]
    parts.append(rod_through(neck, [0.7 * girth, 0.6 * girth, 0.4 * girth]))
    tail = (back - rng.uniform(0.02, 0.06), 0, level + rng.uniform(-0.02, 0.03))
    parts.append(rod_through([(back, 0, level), tail], [0.5 * girth, 0.006]))
    solid = flat_below(Manifold.batch_boolean(parts, OpType.Add), 0.0)
    return model_of_solid(
        'quadruped', solid, {'length': length, 'leg': height, 'girth': girth}, density=RUBBER
    )


def make_bunny(rng: np.random.Generator) -> ObjectModel:
    """Sitting rabbit: a lump with a head, long ears and feet."""
    size = rng.uniform(0.035, 0.058)
    lean = rng.uniform(0.5, 0.9) * size
    head = (lean, 0.0, rng.uniform(1.5, 1.9) * size)
    parts = [ball((0, 0, 0.8 * size), (1.15 * size, 0.9 * size, size))]
    parts.append(ball(head, (0.62 * size, 0.5 * size, 0.52 * size)))
    parts.append(rod_through([(0.3 * lean, 0, size), head], [0.6 * size, 0.4 * size]))
    for side in (-1, 1):
        root = (head[0] - 0.2 * size, side * 0.2 * size, head[2] + 0.3 * size)
        tip = (root[0] - rng.uniform(0.2, 0.6) * size, 2.2 * root[1], root[2] + 0.75 * size)
        parts.append(rod_through([root, tip], [0.18 * size, 0.13 * size]))
        foot = (0.75 * size, side * 0.55 * size, 0.15 * size)
        parts.append(ball(foot, (0.5 * size, 0.25 * size, 0.25 * size)))
    parts.append(ball((-1.1 * size, 0, 0.55 * size), (0.3 * size,) * 3))
    solid = flat_below(Manifold.batch_boolean(parts, OpType.Add), 0.05 * size)
    return model_of_solid('bunny', solid, {'size': size}, density=CERAMIC / 2)


def make_figure(rng: np.random.Generator) -> ObjectModel:
    """Standing figure with arms spread, thick legs and a tail: an armadillo, a toy monster."""
    size = rng.uniform(0.075, 0.12)
    girth = size * rng.uniform(0.2, 0.28)
    hip, neck = 0.42 * size, 0.9 * size
    parts = [rod_through([(0, 0, hip), (0, 0, 0.75 * size)], [girth, girth * 1.1])]
    parts.append(ball((0.1 * girth, 0, 1.12 * size), (0.16 * size, 0.14 * size, 0.17 * size)))
    parts.append(rod_through([(0, 0, neck), (0.2 * girth, 0, 1.05 * size)], [0.1 * size] * 2))
    rise = rng.uniform(-0.15, 0.35)
    for side in (-1, 1):
        foot = (0.12 * size, side * 0.32 * size, 0.03 * size)
        knee = (0.02 * size, side * 0.28 * size, 0.2 * size)
        leg = [(0, side * 0.5 * girth, hip), knee, foot]
        parts.append(rod_through(leg, [0.13 * size, 0.10 * size, 0.09 * size]))
        hand = (0.25 * size, side * 0.55 * size, (0.8 + rise) * size)
        arm = [(0, side * 0.7 * girth, 0.8 * size), (0.1 * size, side * 0.45 * size, 0.75 * size)]
        parts.append(rod_through([*arm, hand], [0.09 * size, 0.07 * size, 0.06 * size]))
    tail = [(-0.5 * girth, 0, hip), (-0.4 * size, 0, 0.12 * size), (-0.5 * size, 0, 0.04 * size)]
    parts.append(rod_through(tail, [0.10 * size, 0.07 * size, 0.05 * size]))
    solid = flat_below(Manifold.batch_boolean(parts, OpType.Add), 0.0)
    return model_of_solid('figure', solid, {'size': size, 'girth': girth}, density=RUBBER)


def make_duck(rng: np.random.Generator) -> ObjectModel:
    """Bath duck: body, head, beak and a raised tail."""
    size = rng.uniform(0.03, 0.05)
    head = (0.55 * size, 0, rng.uniform(1.5, 1.9) * size)
    parts = [ball((0, 0, 0.6 * size), (1.3 * size, 0.9 * size, 0.75 * size))]
    parts.append(ball(head, (0.6 * size,) * 3))
    parts.append(rod_through([(0.4 * size, 0, 0.8 * size), head], [0.5 * size, 0.4 * size]))
    beak = (head[0] + 0.7 * size, 0, head[2] - 0.05 * size)
    parts.append(ball(beak, (0.35 * size, 0.3 * size, 0.12 * size)))
    tail = [(-0.8 * size, 0, 0.8 * size), (-1.4 * size, 0, 1.25 * size)]
    parts.append(rod_through(tail, [0.4 * size, 0.12 * size]))
    solid = flat_below(Manifold.batch_boolean(parts, OpType.Add), 0.1 * size)
    return model_of_solid('duck', solid, {'size': size}, density=RUBBER)


def make_lump(rng: np.random.Generator) -> ObjectModel:
    """Lump of a few balls: fruit, a stone, a piece of ginger."""
    size = rng.uniform(0.028, 0.045)
    parts = [ball((0, 0, 0.8 * size), (size * 1.2, size, size))]
    for _ in range(int(rng.integers(2, 6))):
        angle, reach = rng.uniform(0, 2 * np.pi), rng.uniform(0.5, 1.0) * size
        centre = (reach * np.cos(angle), reach * np.sin(angle), rng.uniform(0.5, 1.4) * size)
        parts.append(ball(centre, tuple(rng.uniform(0.45, 0.9, 3) * size)))
    solid = flat_below(Manifold.batch_boolean(parts, OpType.Add), 0.35 * size)
    return model_of_solid('lump', solid, {'size': size}, density=RUBBER)
