"""Which cases the experiments are made of."""

import dataclasses

import numpy as np
import pytest
from manifold3d import Manifold

from spatial_relations_ros.core import DatasetFormatError, Pose, Relation, TriangleMesh
from spatial_relations_ros.datasets.freiburg import RelationDataset
from spatial_relations_ros.datasets.object_files import save_cloud, save_mesh
from spatial_relations_ros.evaluation.generalization.cases import lowest_point
from spatial_relations_ros.evaluation.generalization.feasibility import (
    check_feasibility,
    remembered_parts,
)
from spatial_relations_ros.evaluation.generalization.known import (
    PAPER_REFERENCES,
    draw_references,
    known_experiment,
)
from spatial_relations_ros.evaluation.generalization.random_cases import random_experiment
from spatial_relations_ros.evaluation.generalization.transformable import impossible_reason
from spatial_relations_ros.evaluation.generalization.unknown import (
    load_unknown_objects,
    pairs_of,
    unknown_experiment,
)
from spatial_relations_ros.evaluation.judging import judge_scene


@pytest.fixture(scope='module')
def references(labelled):
    return draw_references(labelled, seed=0)


def test_two_references_of_each_relation_with_objects_of_their_own(references):
    assert [reference.relation for reference in references] == [
        Relation.ON_TOP, Relation.ON_TOP, Relation.INSIDE, Relation.INSIDE, Relation.NEXT_TO,
        Relation.NEXT_TO, Relation.ON_TOP_EDGE, Relation.ON_TOP_EDGE,
    ]  # fmt: skip
    names = [name for reference in references for name in reference.scene.object_ids]
    assert len(set(names)) == len(names)
    for reference in references:
        lowest = min(lowest_point(item) for item in reference.scene.objects)
        assert lowest == pytest.approx(0.0, abs=1e-7)


def test_scenes_whose_label_geometry_does_not_confirm_are_no_references(labelled):
    wrong = tuple(dataclasses.replace(scene, label=Relation.INCLINED) for scene in labelled.scenes)
    with pytest.raises(DatasetFormatError, match='none of the 8 scenes'):
        draw_references(dataclasses.replace(labelled, scenes=wrong), seed=0)


def test_the_scenes_of_the_paper_are_taken_where_they_are(labelled):
    scenes = tuple(
        dataclasses.replace(labelled.scenes[idx % 8], name=name, label=None)
        for idx, name in enumerate(reversed(PAPER_REFERENCES))
    )
    references = draw_references(dataclasses.replace(labelled, scenes=scenes), seed=5)
    assert [reference.name for reference in references] == list(PAPER_REFERENCES)
    assert [reference.relation for reference in references] == list(PAPER_REFERENCES.values())


def test_known_objects_are_imitated_in_all_ordered_pairs_that_are_possible(references):
    experiment = known_experiment(references)
    # The two inside relations need the other cup: 12 of their 14 pairs have a board as base.
    assert len(experiment.cases) == 8 * 7 - 12
    assert experiment.left_out == {'the base is no container': 12}
    assert [case.number for case in experiment.cases] == list(range(44))
    assert all(case.reference_name != case.test_name for case in experiment.cases)
    assert experiment.thinned(5).cases[-1] is experiment.cases[-1]
    assert len(experiment.thinned(5).cases) == 5


def test_what_does_not_go_through_the_opening_is_left_out(solids):
    cup = solids.cup('cup', 0.05, 0.1, (0, 0, 0)).mesh
    for size, reason in (
        ((0.06, 0.06, 0.2), ''),
        ((0.2, 0.06, 0.06), ''),
        ((0.08, 0.08, 0.08), 'the relative does not fit in'),
        ((0.3, 0.3, 0.02), 'the relative does not fit in'),
    ):
        thing = solids.box('thing', size, (0, 0, 0)).mesh
        assert impossible_reason(Relation.INSIDE, cup, thing) == reason
        assert impossible_reason(Relation.ON_TOP, cup, thing) == ''
        assert impossible_reason(Relation.INSIDE, thing, cup) == 'the base is no container'


def test_what_stands_in_the_hollow_leaves_less_room():
    hollow = Manifold.cube((0.19, 0.19, 0.15), True).translate((0, 0, 0.01))
    crate = Manifold.cube((0.2, 0.2, 0.15), True) - hollow
    post = Manifold.cube((0.05, 0.05, 0.12), True).translate((0, 0, -0.01))
    thing = Manifold.cube((0.1, 0.1, 0.1), True)
    flat = Manifold.cube((0.05, 0.1, 0.1), True)
    crate, post, thing, flat = (
        TriangleMesh(solid.to_mesh().vert_properties[:, :3], solid.to_mesh().tri_verts)
        for solid in (crate, crate + post, thing, flat)
    )
    assert impossible_reason(Relation.INSIDE, crate, thing) == ''
    assert impossible_reason(Relation.INSIDE, post, thing) == 'the relative does not fit in'
    assert impossible_reason(Relation.INSIDE, post, flat) == ''


def test_random_pairs_are_possible_and_start_apart():
    experiment = random_experiment(num_cases=7, num_objects=60, seed=3)
    again = random_experiment(num_cases=7, num_objects=60, seed=3)
    assert [case.relation for case in experiment.cases] == list(Relation)
    for case, other in zip(experiment.cases, again.cases, strict=True):
        assert case.movable == ('relative',)
        assert judge_scene(case.reference, 0.0).relation is case.relation
        assert judge_scene(case.test, 0.0).relation in (None, Relation.NEXT_TO)
        assert judge_scene(case.test, 0.0).measures.clearance > 0.2
        for placed, same in zip(case.test.objects, other.test.objects, strict=True):
            np.testing.assert_array_equal(
                placed.world_from_object.as_matrix(), same.world_from_object.as_matrix()
            )


def test_with_simulation_every_random_pair_has_a_feasible_placement():
    pytest.importorskip('mujoco', reason='needs MuJoCo, the extra physics')
    experiment = random_experiment(num_cases=1, num_objects=40, seed=3, simulate=True)
    for case in experiment.cases:
        judgement = judge_scene(case.reference, 0.0)
        # The demonstrations are drawn in the same way as the placements that are thrown away.
        found = check_feasibility(
            case.reference, judgement.measures, (1000.0, 1000.0), simulate=True
        )
        assert found.feasible, found
    meshes = [item.mesh for case in experiment.cases for item in case.test.objects]
    parts = remembered_parts([*meshes, *meshes])
    assert [mesh for mesh, _ in parts] == list(dict.fromkeys(meshes))


@pytest.fixture
def unknown_folder(tmp_path, solids):
    """A cloud in millimetres with +y up, as the paper's, and an open box of single sheets."""
    points = solids.box('bunny', (80.0, 120.0, 60.0), (0, 0, 0)).mesh.sample_surface(
        20_000, np.random.default_rng(0)
    )
    save_cloud(tmp_path / 'bunny.pcd', points)
    corners = np.array([[x, y, z] for z in (-1, 1) for x in (-1, 1) for y in (-1, 1)], np.float32)
    sheets = [(4, 6, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    triangles = [t for a, b, c, d in sheets for t in ((a, b, c), (a, c, d))]
    save_mesh(tmp_path / 'open_box.ply', TriangleMesh(corners, np.array(triangles, np.int32)))
    return tmp_path


def test_unknown_objects_stand_upright_next_to_each_other(unknown_folder, references):
    models = load_unknown_objects(unknown_folder)
    assert [model.name for model in models] == ['bunny', 'openbox']
    extents = [2.0 * model.half_extents for model in models]
    np.testing.assert_allclose(extents[0], [0.1, 0.075, 0.15], atol=4e-3)
    assert max(extents[1]) == pytest.approx(0.15, abs=4e-3)
    pairs = pairs_of(models, seed=1)
    assert [pair.scene.object_ids for pair in pairs] == [
        ('bunny', 'openbox'), ('openbox', 'bunny'),
    ]  # fmt: skip
    for pair in pairs:
        judgement = judge_scene(pair.scene, 0.0)
        assert judgement.relation is Relation.NEXT_TO, judgement.reason
    box = next(item for item in pairs[1].scene.objects if item.object_id == 'openbox')
    opening = judge_scene(pairs[1].scene, 0.0).measures.opening_up
    assert opening == pytest.approx(1.0, abs=0.05), box.world_from_object
    experiment = unknown_experiment(references, pairs)
    # Six references that need no container, and the two inside ones with the box as base.
    assert len(experiment.cases) == 2 * 6 + 2
    assert experiment.left_out == {'the base is no container': 2}


def test_a_folder_without_pairs_is_refused(tmp_path):
    with pytest.raises(DatasetFormatError, match='holds 0 models'):
        load_unknown_objects(tmp_path / 'none')


def test_objects_without_a_mesh_become_solid(labelled):
    clouds = RelationDataset(labelled.clouds, labelled.scenes[:2])
    references = draw_references(clouds, seed=0)
    assert len(references) == 2
    mesh = references[0].scene.base.mesh
    assert mesh is not None
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), [0.2, 0.16, 0.04], atol=6e-3)
    assert references[0].scene.base.world_from_object.is_close(
        Pose(np.array([0.0, 0.0, 0.02])), metres=3e-3, angle_rad=0.0
    )
