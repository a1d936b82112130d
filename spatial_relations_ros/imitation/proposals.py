"""Placements proposed from the shapes: beside, on, at the edge, in, leaning.

The rules are those that training scenes are made with, so the metric knows what they make. Which
of the results resembles the demonstration is the metric's business.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.imitation.layout import MAX_GAP
from spatial_relations_ros.placement.body import Body, Placed
from spatial_relations_ros.placement.footholds import find_footholds
from spatial_relations_ros.placement.inside import place_inside, place_inside_lying
from spatial_relations_ros.placement.leaning_on import place_inclined, place_inside_inclined
from spatial_relations_ros.placement.on import place_next_to, place_on_edge, place_on_top
from spatial_relations_ros.placement.resting import (
    UP,
    PlacingRule,
    about_axis,
    about_z,
    above,
    dropped,
    half_width,
)
from spatial_relations_ros.placement.settling import Manner, lean_direction, settle
from spatial_relations_ros.placement.tipping import tipped

FloatArray = NDArray[np.float64]

_UPRIGHT_COSINE = 0.95
_LYING_COSINE = 0.5
_ATTEMPTS = 10
_CENTRED = 0.01
_SPACED_SHARE = 0.5
_OVER_SHARE = 0.8
_ALIGNED_SHARE = 0.5
_SHIFT_SHARE = 0.06
_TURN_RAD = math.radians(18.0)
_LEAN_RAD = math.radians(6.0)
_FOOTHOLDS_A_HEADING = 3


@dataclass(frozen=True, eq=False)
class Cell:
    """One way to arrange two bodies: how either stands, and the rule that brings them together.

    Attributes:
        fixed: the base at rest.
        standing: (3, 3) orientation in which the relative rests before it is placed.
        rule: that places it.
        manner: in which it then rests.
    """

    fixed: Placed
    standing: FloatArray
    rule: PlacingRule
    manner: Manner


@dataclass(frozen=True, eq=False)
class Proposal:
    """A pair at rest, as far as moves along straight lines until contact can tell."""

    base: Placed
    relative: Placed
    manner: Manner
    cell: int


def place_over(fixed: Placed, moving: Placed, rng: np.random.Generator) -> Placed | str:
    """Lets a body down anywhere over another one: for tops that are no level."""
    vertices = fixed.world_vertices[:, :2]
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    where = 0.5 * (low + high) + 0.5 * _OVER_SHARE * rng.uniform(-1.0, 1.0, 2) * (high - low)
    return dropped(above(moving, fixed, np.append(where, 0.0)), fixed)


_RULES: tuple[tuple[PlacingRule, Manner], ...] = (
    (place_over, Manner.DROPPED),
    (place_next_to, Manner.BESIDE),
    (place_on_top, Manner.DROPPED),
    (place_on_edge, Manner.DROPPED),
    (place_inclined, Manner.LEANING),
)
_UPRIGHT_CONTAINER_RULES: tuple[tuple[PlacingRule, Manner], ...] = (
    (place_inside, Manner.DROPPED),
    (place_inside_inclined, Manner.IN_RIM),
)
_LYING_CONTAINER_RULES: tuple[tuple[PlacingRule, Manner], ...] = (
    (place_inside_lying, Manner.LOWERED),
)
_LEANING = (Manner.LEANING, Manner.IN_RIM)
_ON_TABLE = (Manner.BESIDE, Manner.LEANING)


class Proposer:
    """Draws placements of a relative around a base.

    Deterministic for a state of the generator.
    """

    def __init__(
        self,
        bases: Sequence[Placed],
        relative: Body,
        orientations: Sequence[FloatArray],
        rng: np.random.Generator,
        *,
        may_lean: bool = True,
        on_table: bool = False,
        heading: FloatArray | None = None,
        spacing: float = 1.0,
    ) -> None:
        """Lists the cells.

        Args:
            bases: ways in which the base may stand, at x = y = 0 on the table z = 0.
            relative: the body to place.
            orientations: (3, 3) each, in which it may stand before it is placed.
            rng: source of everything random.
            may_lean: whether it may be tilted.
            on_table: whether it must stand on the table itself.
            heading: (2,) horizontal unit vector from the base to the relative to keep, or None.
            spacing: at which half of what stands beside the base is placed, 1 where they touch.
        """
        self._heading, self._spacing = heading, spacing
        self._relative = relative.coarse
        self._rng = rng
        self.cells = [
            Cell(base, orientation, rule, manner)
            for base in map(Placed.coarse, bases)
            for rule, manner in _rules_for(base)
            for orientation in orientations
            if (may_lean or manner not in _LEANING) and (not on_table or manner in _ON_TABLE)
        ]

    def draw(self, cell_idx: int) -> Proposal | None:
        """A new placement of a cell; None when some attempts fail."""
        cell = self.cells[cell_idx]
        for _ in range(_ATTEMPTS):
            placed = cell.rule(cell.fixed, self._standing(cell), self._rng)
            if not isinstance(placed, str):
                if cell.manner is Manner.BESIDE and self._rng.random() < _SPACED_SHARE:
                    placed = self._spaced(placed, cell)
                placed = self._headed(placed, cell)
                return Proposal(cell.fixed, placed, cell.manner, cell_idx)
        return None

    def _spaced(self, placed: Placed, cell: Cell) -> Placed:
        """The body moved along its offset until it has the wanted spacing."""
        middles = [_middle(body) for body in (cell.fixed, placed)]
        offset = middles[1] - middles[0]
        distance = float(np.linalg.norm(offset))
        if distance < _CENTRED:
            return placed
        direction = offset / distance
        widths = half_width(cell.fixed, direction) + half_width(placed, direction)
        wanted = min(self._spacing * widths, widths + MAX_GAP)
        moved = placed.moved((wanted - distance) * direction)
        return settle(cell.manner, moved, cell.fixed) or placed

    def _headed(self, placed: Placed, cell: Cell) -> Placed:
        """The body brought to the wanted side of the base, where it can rest there."""
        offset = placed.translation[:2] - cell.fixed.translation[:2]
        if self._heading is None or np.linalg.norm(offset) < _CENTRED:
            return placed
        wanted = math.atan2(self._heading[1], self._heading[0])
        turn = about_z(wanted - math.atan2(offset[1], offset[0]))
        return settle(cell.manner, placed.turned(turn), cell.fixed) or placed

    def vary(self, proposal: Proposal) -> Proposal | None:
        """A placement near another one: shifted, turned and leaning a little otherwise."""
        rng, fixed = self._rng, proposal.base
        reach = fixed.body.radius + self._relative.radius
        shift = np.append(rng.normal(0.0, _SHIFT_SHARE * reach, 2), 0.0)
        rotation = about_z(rng.normal(0.0, _TURN_RAD)) @ proposal.relative.rotation
        moved = Placed(self._relative, rotation, proposal.relative.translation + shift)
        if proposal.manner in _LEANING:
            direction = lean_direction(moved, fixed)
            axis = np.array([-direction[1], direction[0], 0.0])
            turn = about_axis(axis, rng.normal(0.0, _LEAN_RAD))
            moved = Placed(self._relative, turn @ rotation, moved.translation)
        settled = settle(proposal.manner, moved, fixed)
        return (
            None if settled is None else Proposal(fixed, settled, proposal.manner, proposal.cell)
        )

    def on_footholds(self, count: int) -> Iterator[Proposal]:
        """Placements on the steadiest footholds of as many as a look at each pair of ways finds.

        Every way in which the relative is let down onto one in which the base stands is looked at
        once, at a new heading each time.
        """
        found: list[tuple[float, int, Placed]] = []
        for idx in self._ways_to_drop():
            moving, fixed = self._standing(self.cells[idx]), self.cells[idx].fixed
            there = find_footholds(moving, fixed, self._rng)
            for place in np.argsort(-there.hold)[:_FOOTHOLDS_A_HEADING]:
                moved = moving.moved(np.append(there.offsets[place], 0.0))
                found.append((float(there.hold[place]), idx, moved))
        found.sort(key=lambda entry: -entry[0])
        for _, idx, moving in found[:count]:
            fixed = self.cells[idx].fixed
            top = float(fixed.world_vertices[:, 2].max())
            placed = tipped(dropped(moving.moved(top * UP), fixed), fixed)
            if placed is not None:
                yield Proposal(fixed, placed, Manner.DROPPED, idx)

    def _ways_to_drop(self) -> list[int]:
        """One cell for each way in which the base stands with each in which the relative does."""
        ways = {
            (id(cell.fixed), id(cell.standing)): idx
            for idx, cell in enumerate(self.cells)
            if cell.rule is place_over
        }
        return list(ways.values())

    def _standing(self, cell: Cell) -> Placed:
        yaw = self._rng.uniform(0.0, 2.0 * np.pi)
        if self._rng.random() < _ALIGNED_SHARE:
            yaw = _heading(cell.fixed.rotation) + 0.5 * np.pi * self._rng.integers(4)
            yaw -= _heading(cell.standing)
        return Placed(self._relative, about_z(yaw) @ cell.standing, np.zeros(3)).on_table()


def _rules_for(base: Placed) -> Iterator[tuple[PlacingRule, Manner]]:
    yield from _RULES
    if base.body.model.is_container:
        upwards = float(base.rotation[2, 2])
        if upwards > _UPRIGHT_COSINE:
            yield from _UPRIGHT_CONTAINER_RULES
        elif abs(upwards) < _LYING_COSINE:
            yield from _LYING_CONTAINER_RULES


def _middle(placed: Placed) -> FloatArray:
    """Middle (3,) of a body seen from above, at height 0."""
    vertices = placed.world_vertices
    return np.asarray(0.5 * (vertices.min(axis=0) + vertices.max(axis=0)) * [1.0, 1.0, 0.0])


def _heading(rotation: FloatArray) -> float:
    """Horizontal angle of the frame's most level axis among x and y."""
    axis = int(np.abs(rotation[2, :2]).argmin())
    return float(np.arctan2(rotation[1, axis], rotation[0, axis]))
