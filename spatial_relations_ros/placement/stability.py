"""Whether bodies at rest stay at rest: static equilibrium with Coulomb friction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from spatial_relations_ros.placement.body import FloatArray, Placed
from spatial_relations_ros.placement.contact import (
    Contacts,
    find_contacts,
    table_contacts,
)

FRICTION = 0.5
TABLE_TILT_RAD = float(np.deg2rad(4.0))
_LEVER = 0.1
_MAX_CONTACTS = 28
_RESIDUAL = 0.01
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class RestingContacts:
    """All contacts of a scene on the table z = 0."""

    base_table: Contacts
    relative_table: Contacts
    base_relative: Contacts


def resting_contacts(base: Placed, relative: Placed) -> RestingContacts:
    """Finds the contacts between base, relative and table."""
    return RestingContacts(
        table_contacts(base), table_contacts(relative), find_contacts(base, relative)
    )


def equilibrium_residual(
    base: Placed,
    relative: Placed,
    contacts: RestingContacts,
    *,
    friction: float = FRICTION,
    up: FloatArray = UP,
) -> float:
    """How far the scene is from static equilibrium; 0 is at rest, 1 is free fall.

    Looks for contact forces within (linearised) friction cones that balance the weights of both
    bodies: non-negative least squares on the two force and torque balances, torques about each
    centre of mass divided by 0.1 m. The result is the residual's share of the weights.
    """
    return _residual(_contact_wrenches(base, relative, contacts, friction), up)


def is_stable(
    base: Placed,
    relative: Placed,
    contacts: RestingContacts,
    *,
    tilt_rad: float = TABLE_TILT_RAD,
) -> bool:
    """Whether friction of 0.5 holds both bodies at rest, even on a slightly tilted table.

    The tilt, by 4 degrees in each of six directions, leaves out what would fall at a touch.
    """
    return _balances(_contact_wrenches(base, relative, contacts, FRICTION), tilt_rad)


def holds_still(
    body: Placed, contacts: Sequence[Contacts], *, tilt_rad: float = TABLE_TILT_RAD
) -> bool:
    """The same for one body among others that do not move; normals point into the body."""
    centres = [body.centre_of_mass()]
    columns = [_wrenches(contact, centres, (1.0,), FRICTION) for contact in contacts]
    return _balances(np.concatenate(columns, axis=1), tilt_rad)


def _balances(wrenches: FloatArray, tilt_rad: float) -> bool:
    """Whether contact forces can carry unit weights, upright and on tilted tables."""
    if _residual(wrenches, UP) > _RESIDUAL:
        return False
    angles = np.arange(6) * (np.pi / 3.0)
    tilted = np.stack([np.cos(angles), np.sin(angles), np.full(6, 1.0 / np.tan(tilt_rad))], 1)
    tilted /= np.linalg.norm(tilted, axis=1, keepdims=True)
    return all(_residual(wrenches, up) <= _RESIDUAL for up in tilted)


def _residual(wrenches: FloatArray, up: FloatArray) -> float:
    if wrenches.shape[1] == 0:
        return 1.0
    num_bodies = len(wrenches) // 6
    weights = np.tile(np.append(up, np.zeros(3)), num_bodies)
    try:
        _, residual = nnls(wrenches, weights)
    except RuntimeError:  # no convergence: take it as unstable
        return 1.0
    return float(residual / np.sqrt(num_bodies))


def _contact_wrenches(
    base: Placed, relative: Placed, contacts: RestingContacts, friction: float
) -> FloatArray:
    """Forces and torques (12, K) on base and relative of unit contact forces."""
    bodies = (base, relative)
    centres = [body.centre_of_mass() for body in bodies]
    columns = [
        _wrenches(contacts.base_table, centres, (1.0, 0.0), friction),
        _wrenches(contacts.relative_table, centres, (0.0, 1.0), friction),
        _wrenches(contacts.base_relative, centres, (-1.0, 1.0), friction),
    ]
    matrix = np.concatenate(columns, axis=1)
    # Each body's rows are divided by its own weight, so that a light one counts as much.
    matrix[:6] /= base.body.model.mass_properties.mass
    matrix[6:] /= relative.body.model.mass_properties.mass
    return matrix


def _wrenches(
    contacts: Contacts, centres: list[FloatArray], signs: tuple[float, ...], friction: float
) -> FloatArray:
    picked = _spread(contacts.points)
    points, normals = contacts.points[picked], contacts.normals[picked]
    if not len(points):
        return np.zeros((6 * len(centres), 0))
    helper = np.where(np.abs(normals[:, :1]) < 0.7, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    tangent_1 = _cross(normals, helper)
    tangent_1 /= np.linalg.norm(tangent_1, axis=1, keepdims=True)
    tangent_2 = _cross(normals, tangent_1)
    forces = np.concatenate(
        [normals + friction * t for t in (tangent_1, -tangent_1, tangent_2, -tangent_2)]
    )
    points = np.tile(points, (4, 1))
    rows = []
    for centre, sign in zip(centres, signs, strict=True):
        torques = _cross(points - centre, forces) / _LEVER
        rows += [sign * forces.T, sign * torques.T]
    return np.concatenate(rows)


def _cross(first: FloatArray, second: FloatArray) -> FloatArray:
    """Cross products (N, 3); a small part of the time of numpy's."""
    forth, back = [1, 2, 0], [2, 0, 1]
    crossed: FloatArray = first[:, forth] * second[:, back] - first[:, back] * second[:, forth]
    return crossed


def _spread(points: FloatArray) -> np.ndarray:
    """Indices of at most ``_MAX_CONTACTS`` points: the outermost ones, then an even choice."""
    if len(points) <= _MAX_CONTACTS:
        return np.arange(len(points))
    angles = np.arange(12) * (2.0 * np.pi / 12.0)
    directions = np.stack([np.cos(angles), np.sin(angles), np.zeros(12)], axis=1)
    directions = np.concatenate([directions, [[0, 0, 1], [0, 0, -1]]])
    outermost = (points @ directions.T).argmax(axis=0)
    rest = np.linspace(0, len(points) - 1, _MAX_CONTACTS - 14).astype(np.int64)
    return np.unique(np.concatenate([outermost, rest]))
