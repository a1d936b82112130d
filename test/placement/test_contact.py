"""Contacts of simple bodies whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from spatial_relations_ros.datasets.objects.model_of_solid import model_of_solid
from spatial_relations_ros.datasets.objects.solids import box, solid_of_wall
from spatial_relations_ros.placement.body import Body, Placed
from spatial_relations_ros.placement.contact import (
    clearance,
    find_contacts,
    first_contact,
    table_contacts,
    travel_to_contact,
)
from spatial_relations_ros.placement.resting import DOWN, about_axis, about_z


def body_of(solid) -> Body:
    return Body.of(model_of_solid('test', solid, {}))


@pytest.fixture(scope='module')
def cube() -> Body:
    return body_of(box((0.1, 0.1, 0.1)))


@pytest.fixture(scope='module')
def rod() -> Body:
    return body_of(solid_of_wall([(0.02, 0.0), (0.02, 0.2)]))


def at(body: Body, translation, rotation=None) -> Placed:
    return Placed(body, np.eye(3) if rotation is None else rotation, np.array(translation))


def test_a_cube_falls_onto_a_cube(cube):
    travel = travel_to_contact(at(cube, [0.03, 0.02, 0.5]), at(cube, [0, 0, 0]), DOWN)
    assert travel == pytest.approx(0.4, abs=1e-6)


def test_a_cube_that_misses_travels_for_ever(cube):
    assert travel_to_contact(at(cube, [0.2, 0, 0.5]), at(cube, [0, 0, 0]), DOWN) == np.inf


def test_first_contact_is_the_same_seen_from_either_body(cube, rod):
    turned = about_axis(np.array([1.0, 0.0, 0.0]), 0.6) @ about_z(0.3)
    moving, fixed = at(rod, [0.01, 0.02, 0.5], turned), at(cube, [0, 0, 0])
    there, point = first_contact(moving, fixed, DOWN)
    back, same_point = first_contact(fixed, moving, -DOWN)
    assert there == pytest.approx(back, abs=1e-6)
    np.testing.assert_allclose(point + DOWN * 0, same_point - DOWN * -there, atol=1e-5)


def test_crossing_edges_meet_within_a_fraction_of_a_millimetre(cube):
    # A cube that stands on its edge falls across an edge of another one that does so too.
    on_edge_x = about_axis(np.array([1.0, 0.0, 0.0]), np.pi / 4)
    on_edge_y = about_axis(np.array([0.0, 1.0, 0.0]), np.pi / 4)
    fixed = at(cube, [0, 0, 0], on_edge_x)
    moving = at(cube, [0.0037, 0.0013, 0.5], on_edge_y)
    # Ridges: z = top - |y| below, z = bottom + |x - 0.0037| above; they cross over x = 0.0037.
    expected = 0.5 - 2 * 0.05 * np.sqrt(2)
    travel = travel_to_contact(moving, fixed, DOWN)
    assert travel == pytest.approx(expected, abs=1.5e-3)
    assert travel >= expected - 1e-6


def test_clearance_is_the_gap_and_turns_negative_in_penetration(cube):
    fixed = at(cube, [0, 0, 0])
    assert clearance(at(cube, [0.103, 0, 0]), fixed) == pytest.approx(0.003, abs=1e-6)
    assert clearance(at(cube, [0.25, 0, 0]), fixed) == pytest.approx(0.15, abs=1e-6)
    assert clearance(at(cube, [0.098, 0.01, 0]), fixed) == pytest.approx(-0.002, abs=1e-4)


def test_contacts_of_stacked_cubes_cover_the_common_face(cube):
    contacts = find_contacts(at(cube, [0, 0, 0.05]), at(cube, [0.04, 0, 0.15]))
    np.testing.assert_allclose(
        contacts.normals, np.tile([0, 0, 1.0], (len(contacts), 1)), atol=1e-5
    )
    np.testing.assert_allclose(contacts.points[:, 2], 0.1, atol=1e-3)
    low, high = contacts.points.min(axis=0), contacts.points.max(axis=0)
    np.testing.assert_allclose(low[:2], [-0.01, -0.05], atol=2e-3)
    np.testing.assert_allclose(high[:2], [0.05, 0.05], atol=2e-3)


def test_a_leaning_rod_is_held_normal_to_its_own_side(cube, rod):
    angle = np.deg2rad(30.0)
    tilted = at(rod, [-0.2, 0.0, 0.0], about_axis(np.array([0.0, 1.0, 0.0]), angle)).on_table()
    fixed = at(cube, [0, 0, 0.05])
    direction = np.array([1.0, 0.0, 0.0])
    leaning = tilted.moved(direction * travel_to_contact(tilted, fixed, direction))
    contacts = find_contacts(fixed, leaning)
    assert len(contacts) > 0
    np.testing.assert_allclose(contacts.points[:, 0], -0.05, atol=1.5e-3)
    np.testing.assert_allclose(contacts.points[:, 2], 0.1, atol=1.5e-3)
    expected = [-np.cos(angle), 0.0, np.sin(angle)]
    # The round side is within a millimetre of the edge over some strips of 7.5 degrees each.
    assert (contacts.normals @ expected > np.cos(np.deg2rad(20.0))).all()
    np.testing.assert_allclose(contacts.normals.mean(axis=0), expected, atol=0.05)


def test_no_contacts_across_a_gap(cube):
    assert len(find_contacts(at(cube, [0, 0, 0]), at(cube, [0, 0, 0.1021]))) == 0


def test_table_contacts_are_the_lowest_vertices(cube):
    contacts = table_contacts(at(cube, [0.3, 0, 0.4]).on_table())
    assert len(contacts) == 4
    np.testing.assert_allclose(contacts.points[:, 2], 0.0, atol=1e-7)
