"""The judge on scenes whose relation is known by construction, and on generated ones."""

import dataclasses
import math
import re

import numpy as np
import pytest

from spatial_relations_ros.core import (
    InvalidSceneError,
    Pose,
    Relation,
    Scene,
    SceneObject,
    TriangleMesh,
)
from spatial_relations_ros.datasets.objects import sample_object
from spatial_relations_ros.evaluation.judging import (
    JudgeLimits,
    Tolerances,
    compare_relations,
    judge_scene,
    measure_scene,
)
from spatial_relations_ros.evaluation.judging.solid import solid_of

BOX_CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
BOX_FACES = [
    (0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3),
]  # fmt: skip


def box_mesh(x, y, z):
    """A box centred at the origin with edges x, y, z."""
    triangles = [t for a, b, c, d in BOX_FACES for t in ((a, b, c), (a, c, d))]
    vertices = 0.5 * BOX_CORNERS * [x, y, z]
    return TriangleMesh(vertices.astype(np.float32), np.array(triangles, dtype=np.int32))


def cup_mesh(radius=0.05, height=0.1, wall=0.004, sides=48, turn=0.0):
    """A cup open to +z, its floor's outer face at z = 0."""
    profile = [
        (0.0, 0.0), (radius, 0.0), (radius, height), (radius - wall, height),
        (radius - wall, wall), (0.0, wall),
    ]  # fmt: skip
    angles = (np.arange(sides) + 0.5 * turn * sides) * 2.0 * np.pi / sides
    rings = np.array(
        [[r * np.cos(a), r * np.sin(a), z] for r, z in profile[1:-1] for a in angles]
        + [[0.0, 0.0, profile[0][1]], [0.0, 0.0, profile[-1][1]]]
    )
    bottom, floor = len(rings) - 2, len(rings) - 1
    triangles = []
    for side in range(sides):
        after = (side + 1) % sides
        triangles.append((bottom, after, side))
        for ring in range(3):
            low, high = ring * sides, (ring + 1) * sides
            triangles.append((low + side, low + after, high + after))
            triangles.append((low + side, high + after, high + side))
        triangles.append((floor, 3 * sides + side, 3 * sides + after))
    return TriangleMesh(rings.astype(np.float32), np.array(triangles, dtype=np.int32))


def tray_mesh():
    """A square tray of 12 x 12 x 6 cm with walls of 1 cm, open to +z."""
    return cup_mesh(radius=0.06 * math.sqrt(2.0), height=0.06, wall=0.01, sides=4, turn=0.25)


def about(axis, degrees):
    half = math.radians(degrees) / 2.0
    return np.array([math.cos(half), *(math.sin(half) * np.eye(3)['xyz'.index(axis)])])


def item(name, mesh, translation=(0.0, 0.0, 0.0), quat_wxyz=(1.0, 0.0, 0.0, 0.0)):
    pose = Pose(np.array(translation, dtype=np.float64), np.array(quat_wxyz, dtype=np.float64))
    return SceneObject(name, mesh.vertices, pose, mesh=mesh)


BRICK = box_mesh(0.06, 0.04, 0.1)
BOARD = box_mesh(0.2, 0.15, 0.05)
PEN = box_mesh(0.01, 0.01, 0.16)
DIE = box_mesh(0.03, 0.03, 0.03)
CUP = cup_mesh()


def board_with(mesh, translation, quat_wxyz=(1.0, 0.0, 0.0, 0.0)):
    """Something with a board that lies on the table z = 0."""
    return Scene(item('board', BOARD, (0, 0, 0.025)), item('thing', mesh, translation, quat_wxyz))


def leaning_pen(degrees=35.0):
    """A pen that stands on the table and leans on the upper edge of the board at x = 0.1."""
    tilt = math.radians(degrees)
    # The lower face's near edge is at half width; the side that looks down meets the edge.
    normal = np.array([-math.cos(tilt), 0.0, -math.sin(tilt)])
    along = np.array([-math.sin(tilt), 0.0, math.cos(tilt)])
    edge = np.array([0.1, 0.0, 0.05])
    lowest = 0.08 * along[2] + 0.005 * abs(normal[2])
    centre = edge - 0.005 * normal
    centre = centre + along * (lowest - centre[2]) / along[2]
    return board_with(PEN, centre, about('y', -degrees))


def in_cup(mesh, translation, quat_wxyz=(1.0, 0.0, 0.0, 0.0), *, lying=False):
    base = item('cup', CUP, (0, 0, 0.05), about('y', 90.0)) if lying else item('cup', CUP)
    return Scene(base, item('thing', mesh, translation, quat_wxyz))


CASES = {
    'brick on the board': (board_with(BRICK, (0.01, 0.0, 0.1)), Relation.ON_TOP),
    'brick upside down on the board': (
        board_with(BRICK, (0, 0, 0.1), about('x', 180)),
        Relation.ON_TOP,
    ),
    'board on the brick': (
        Scene(item('brick', BRICK, (0, 0, 0.05)), item('board', BOARD, (0.003, 0, 0.125))),
        Relation.ON_TOP,
    ),
    'brick over the edge': (board_with(BRICK, (0.09, 0.0, 0.1)), Relation.ON_TOP_EDGE),
    'brick over the corner': (board_with(BRICK, (0.09, 0.07, 0.1)), Relation.ON_TOP_EDGE),
    'brick beside the board': (board_with(BRICK, (0.16, 0, 0.05)), Relation.NEXT_TO),
    'brick that touches the board': (board_with(BRICK, (0.13, 0, 0.05)), Relation.NEXT_TO),
    'lying brick beside the board': (
        board_with(BRICK, (0.2, 0, 0.02), about('x', 90)),
        Relation.NEXT_TO,
    ),
    'pen leaning on the board': (leaning_pen(), Relation.INCLINED),
    'die in the cup': (in_cup(DIE, (0.01, 0, 0.019)), Relation.INSIDE),
    'brick that looks out of the cup': (in_cup(BRICK, (0, 0, 0.054)), Relation.INSIDE),
    'die in the lying cup': (in_cup(DIE, (0.04, 0, 0.019), lying=True), Relation.INSIDE_LYING),
    'pen in the cup': (
        in_cup(PEN, (0.005, 0, 0.082), about('y', 24.0)),
        Relation.INSIDE_INCLINED,
    ),
    'die on the lying cup': (
        in_cup(DIE, (0.05, 0.0, 0.115), lying=True),
        Relation.ON_TOP,
    ),
    'die on a lying tray of thick walls': (
        Scene(
            item('tray', tray_mesh(), (0, 0, 0.06), about('y', 90.0)),
            item('die', DIE, (0.02, 0.0, 0.135 - 1e-6)),
        ),
        Relation.ON_TOP,
    ),
    'brick on the cup turned over': (
        Scene(
            item('cup', CUP, (0, 0, 0.1), about('x', 180)),
            item('brick', BRICK, (0, 0, 0.15)),
        ),
        Relation.ON_TOP,
    ),
}


@pytest.mark.parametrize('name', CASES)
def test_constructed_scenes(name):
    scene, relation = CASES[name]
    judgement = judge_scene(scene, 0.0, limits=JudgeLimits(penetration=0.01))
    assert judgement.relation is relation, judgement.reason


@pytest.mark.parametrize('name', CASES)
def test_the_heading_and_place_of_the_scene_do_not_matter(name):
    scene, relation = CASES[name]
    motion = Pose(np.array([0.3, -0.2, 0.7]), about('z', 77.0))
    moved = scene.with_poses(
        motion @ scene.base.world_from_object, motion @ scene.relative.world_from_object
    )
    judgement = judge_scene(moved, 0.7, limits=JudgeLimits(penetration=0.01))
    assert judgement.relation is relation, judgement.reason


@pytest.mark.parametrize(
    ('scene', 'table_height', 'reason'),
    [
        (board_with(BRICK, (0.0, 0.0, 0.12)), 0.0, 'floats 70 mm high'),
        (board_with(BRICK, (0.0, 0.0, 0.08)), 0.0, 'overlap by 2[0-9] mm'),
        (board_with(BRICK, (0.16, 0.0, 0.05)), 0.02, '20 mm below the table'),
        (board_with(BRICK, (0.16, 0.0, 0.05)), -0.02, 'the base is 20 mm above'),
        (board_with(BRICK, (1.0, 0.0, 0.05)), 0.0, 'cm apart'),
        (board_with(PEN, (0.3, 0.0, 0.07), about('y', 30.0)), 0.0, 'nothing to lean on'),
    ],
)
def test_what_is_no_relation_is_said(scene, table_height, reason):
    judgement = judge_scene(scene, table_height)
    assert judgement.relation is None
    assert re.search(reason, judgement.reason), judgement.reason


def test_the_measures_of_a_brick_over_the_edge():
    measures = measure_scene(board_with(BRICK, (0.09, 0.0, 0.1)), 0.0)
    assert measures.footing is not None
    assert measures.footing.overhang == pytest.approx(0.02 / 0.06, abs=0.01)
    assert measures.clearance == pytest.approx(0.0, abs=1e-4)
    assert measures.tilt_rad == pytest.approx(0.0, abs=1e-3)
    assert measures.contact_heights == pytest.approx((0.05, 0.05), abs=4e-3)
    np.testing.assert_allclose(measures.offset, [0.09, 0.0, 0.075], atol=1e-6)


@pytest.mark.parametrize('gap', [0.004, 0.02, 0.05, 0.3])
def test_the_clearance_of_boxes_side_by_side(gap):
    measures = measure_scene(board_with(BRICK, (0.13 + gap, 0.01, 0.05)), 0.0)
    assert measures.clearance == pytest.approx(gap, abs=1e-3)


def test_the_tilt_is_to_the_nearest_way_to_stand():
    for degrees, expected in ((20.0, 20.0), (80.0, 10.0), (170.0, 10.0)):
        scene = board_with(BRICK, (0.5, 0.0, 0.2), about('x', degrees))
        assert math.degrees(measure_scene(scene, 0.0).tilt_rad) == pytest.approx(expected, abs=0.1)


def test_the_hollow_of_a_cup():
    hollow = solid_of(CUP).hollow
    assert hollow is not None
    np.testing.assert_allclose(hollow.opening, [0.0, 0.0, 1.0], atol=0.02)
    assert hollow.depth == pytest.approx(0.096, abs=0.006)
    assert hollow.width == pytest.approx(0.092, abs=0.008)
    assert solid_of(BRICK).hollow is None


def test_a_full_cup_is_no_container():
    can = sample_object('can', np.random.default_rng(0), name='can0')
    assert solid_of(can.mesh).hollow is None


def test_objects_without_a_mesh_are_refused():
    scene = board_with(BRICK, (0, 0, 0.1))
    bare = dataclasses.replace(scene, relative=dataclasses.replace(scene.relative, mesh=None))
    with pytest.raises(InvalidSceneError, match='thing has no mesh'):
        judge_scene(bare)
    sheet = TriangleMesh(
        np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], np.float32),
        np.array([[0, 1, 2], [1, 3, 2]], np.int32),
    )
    with pytest.raises(InvalidSceneError, match='encloses no volume'):
        judge_scene(Scene(scene.base, item('sheet', sheet)))


def test_a_scene_agrees_with_itself_and_with_its_mirror_image():
    reference = judge_scene(board_with(BRICK, (0.09, 0.0, 0.1)))
    mirrored = judge_scene(board_with(BRICK, (0.0, -0.07, 0.1), about('z', 90.0)))
    assert compare_relations(reference, reference).same_relation
    assert compare_relations(reference, mirrored).same_relation


def test_differences_are_named():
    reference = judge_scene(leaning_pen(13.0))
    assert reference.relation is Relation.INCLINED
    steeper = compare_relations(reference, judge_scene(leaning_pen(44.0)))
    assert steeper.same_class
    assert not steeper.same_relation
    assert [item.quantity for item in steeper.differences] == ['lean']
    assert steeper.words[0].startswith('lean 0.77 instead of 0.23')
    wide = Tolerances(lean_rad=1.0)
    assert compare_relations(reference, judge_scene(leaning_pen(44.0)), wide).same_relation
    other = compare_relations(reference, judge_scene(board_with(BRICK, (0, 0, 0.1))))
    assert not other.same_class
    assert not other.differences
    assert 'on top instead of inclined' in other.words[0]


def quantities(reference, result):
    compared = compare_relations(judge_scene(reference, 0.0), judge_scene(result, 0.0))
    assert compared.same_class
    return [item.quantity for item in compared.differences]


def beside(gap, mesh=BRICK, half_width=0.03, half_height=0.05):
    """Something that stands beside the board with a gap along x."""
    return board_with(mesh, (0.1 + half_width + gap, 0.0, half_height))


def test_a_flat_pair_may_stand_as_a_tall_pair_does():
    tower = Scene(
        item('one', box_mesh(0.05, 0.05, 0.4), (0, 0, 0.2)),
        item('two', box_mesh(0.05, 0.05, 0.05), (0.06, 0, 0.025)),
    )
    plates = Scene(
        item('one', box_mesh(0.2, 0.2, 0.01), (0, 0, 0.005)),
        item('two', box_mesh(0.1, 0.1, 0.02), (0.18, 0, 0.01)),
    )
    assert quantities(tower, plates) == []


@pytest.mark.parametrize(
    ('gap', 'differs'), [(0.0, []), (0.03, []), (0.06, ['offset']), (0.15, ['offset'])]
)
def test_a_gap_is_a_share_of_what_stands_beside_it(gap, differs):
    # The sum of the half widths is 13 cm, the tolerance 0.3 of it.
    assert quantities(beside(0.0), beside(gap)) == differs


def test_far_apart_the_tolerance_grows():
    assert quantities(beside(0.15), beside(0.08)) == []
    assert quantities(beside(0.15), beside(0.01)) == ['offset']


@pytest.mark.parametrize(('depth', 'differs'), [(0.03, []), (0.1, ["height over the base's top"])])
def test_what_hangs_down_beside_the_contacts_counts_when_it_is_more_than_half(depth, differs):
    """A lid on a post is as much on top of it as a brick on a board is; a deep cup is not."""
    post = item('post', box_mesh(0.04, 0.04, 0.15), (0, 0, 0.075))
    lid = item('lid', cup_mesh(height=depth), (0, 0, 0.154), about('x', 180.0))
    assert quantities(board_with(BRICK, (0.0, 0.0, 0.1)), Scene(post, lid)) == differs


def test_what_stands_near_the_border_is_not_asked_of_a_pair_of_one_size():
    near_border = board_with(DIE, (0.08, 0.0, 0.065))
    assert quantities(near_border, board_with(DIE, (0.0, 0.0, 0.065))) == ['offset']
    cubes = Scene(
        item('one', box_mesh(0.06, 0.06, 0.06), (0, 0, 0.03)),
        item('two', box_mesh(0.055, 0.055, 0.055), (0, 0, 0.0875)),
    )
    assert quantities(near_border, cubes) == []


def test_a_plate_on_its_rim_leans_as_a_book_does():
    book, plate = (
        dataclasses.replace(
            judge_scene(leaning_pen(20.0)).measures, tilt_rad=math.radians(degrees)
        )
        for degrees in (20.0, 72.0)
    )
    judged = [
        dataclasses.replace(judge_scene(leaning_pen(20.0)), measures=item)
        for item in (book, plate)
    ]
    assert compare_relations(*judged).same_relation


def test_the_outline_offset_of_boxes_side_by_side_is_one_at_any_heading():
    for degrees in (0.0, 30.0, 77.0):
        pose = Pose(np.zeros(3), about('z', degrees))
        scene = beside(0.0)
        turned = scene.with_poses(
            pose @ scene.base.world_from_object, pose @ scene.relative.world_from_object
        )
        outline = measure_scene(turned, 0.0).outline
        assert outline.share == pytest.approx(1.0, abs=5e-3)
        assert outline.distance == pytest.approx(0.13, abs=1e-3)
        assert outline.base_half_width == pytest.approx(0.1, abs=1e-3)
