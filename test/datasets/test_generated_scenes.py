"""Each relation's geometry, measured on the scenes' world meshes apart from the generator."""

from __future__ import annotations

import numpy as np
import open3d as o3d
import pytest
from scipy.spatial import ConvexHull

from spatial_relations_ros.core import Relation, SpatialRelationsError
from spatial_relations_ros.datasets.generator import (
    Measured,
    SceneSampler,
    generate_objects,
    sample_scene,
)
from spatial_relations_ros.datasets.generator.checks import LEAST_LEAN_RAD
from spatial_relations_ros.datasets.objects import sample_object
from spatial_relations_ros.placement.body import Body
from spatial_relations_ros.placement.rest_poses import RestKind
from spatial_relations_ros.placement.resting import sample_rest_pose

SCENES_PER_RELATION = 4


@pytest.fixture(scope='module')
def sampler() -> SceneSampler:
    return SceneSampler([Body.of(model) for model in generate_objects(36, seed=1)])


@pytest.fixture(scope='module')
def scenes(sampler) -> dict[Relation, list[WorldScene]]:
    return {
        relation: [
            WorldScene(
                sampler.sample(relation, np.random.default_rng([2, int(relation), k])).measured
            )
            for k in range(SCENES_PER_RELATION)
        ]
        for relation in Relation
    }


class WorldScene:
    """Base and relative as meshes in the world, with dense samples of their surfaces."""

    def __init__(self, measured: Measured) -> None:
        self.measured = measured
        self.base, self.relative = measured.base, measured.relative
        poses = [placed.pose() for placed in (self.base, self.relative)]
        meshes = [
            placed.body.model.mesh.transformed(pose)
            for placed, pose in zip((self.base, self.relative), poses, strict=True)
        ]
        self.base_mesh, self.relative_mesh = meshes
        rng = np.random.default_rng(5)
        samples = [
            np.concatenate([mesh.vertices, mesh.sample_surface(8_000, rng)]) for mesh in meshes
        ]
        self.base_points, self.relative_points = samples
        to_relative = signed_distances(self.relative_mesh, self.base_points)
        to_base = signed_distances(self.base_mesh, self.relative_points)
        self.clearance = min(to_relative.min(), to_base.min())
        self.touching = np.concatenate(
            [
                self.base_points[to_relative < 0.0015],
                self.relative_points[to_base < 0.0015],
            ]
        )

    @property
    def lean_rad(self) -> float:
        """Angle to the nearest orientation in which the relative rests on a level ground."""
        return level_angle(self.relative)


def signed_distances(mesh, points) -> np.ndarray:
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        o3d.core.Tensor.from_numpy(np.array(mesh.vertices)),
        o3d.core.Tensor.from_numpy(mesh.triangles.astype(np.uint32)),
    )
    query = o3d.core.Tensor.from_numpy(np.asarray(points, dtype=np.float32))
    return scene.compute_signed_distance(query).numpy()


def level_angle(placed) -> float:
    cosines = placed.body.model.level_axes @ placed.rotation[2]
    return float(np.arccos(np.clip(cosines.max(), -1.0, 1.0)))


def share_of_hull(points, hull_points) -> float:
    """Share of points within the convex hull of others, both (N, 3)."""
    hull = ConvexHull(hull_points)
    outside = points @ hull.equations[:, :-1].T + hull.equations[:, -1]
    return float((outside.max(axis=1) < 1e-3).mean())


@pytest.mark.parametrize('relation', Relation)
def test_nothing_penetrates_or_sinks(scenes, relation):
    for scene in scenes[relation]:
        assert scene.clearance > -0.0015
        lowest = min(
            scene.base_mesh.vertices[:, 2].min(), scene.relative_mesh.vertices[:, 2].min()
        )
        assert lowest == pytest.approx(0.0, abs=1e-4)
        np.testing.assert_allclose(scene.base.translation[:2], 0.0, atol=1e-9)


@pytest.mark.parametrize('relation', Relation)
def test_objects_touch_unless_they_stand_apart(scenes, relation):
    for scene in scenes[relation]:
        if relation is Relation.NEXT_TO:
            assert 0.0 < scene.clearance < 0.151
        else:
            assert scene.clearance < 0.0015
            assert len(scene.touching) > 0


@pytest.mark.parametrize('relation', Relation)
def test_the_base_rests_level_on_the_table(scenes, relation):
    for scene in scenes[relation]:
        assert scene.base_mesh.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-4)
        assert level_angle(scene.base) < 1e-3


def test_next_to_both_rest_on_the_table_beside_each_other(scenes):
    for scene in scenes[Relation.NEXT_TO]:
        assert scene.relative_mesh.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-4)
        assert scene.lean_rad < 1e-3


@pytest.mark.parametrize('relation', [Relation.ON_TOP, Relation.ON_TOP_EDGE])
def test_on_top_the_relative_is_level_and_its_weight_above_the_contacts(scenes, relation):
    for scene in scenes[relation]:
        bottom = scene.relative_mesh.vertices[:, 2].min()
        rim = scene.base_mesh.vertices[:, 2].max()
        assert scene.lean_rad < 1e-3
        # A plate's hollow is the only thing on which something stands below the top.
        assert rim - bottom < (0.008 if scene.base.body.model.is_container else 0.035)
        centre = scene.relative.centre_of_mass()[:2]
        for angle in np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False):
            direction = np.array([np.cos(angle), np.sin(angle)])
            assert (scene.touching[:, :2] @ direction).max() > centre @ direction


def overhangs(scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Reach of foot beyond support, width of the foot and of the support in 48 directions."""
    bottom = scene.relative_points[:, 2].min()
    foot = scene.relative_points[scene.relative_points[:, 2] < bottom + 0.002, :2]
    support = scene.base_points[scene.base_points[:, 2] > bottom - 0.003, :2]
    angles = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    directions = np.stack([np.cos(angles), np.sin(angles)])
    reach = (foot @ directions).max(axis=0) - (support @ directions).max(axis=0)
    return reach, np.ptp(foot @ directions, axis=0), np.ptp(support @ directions, axis=0)


def extent(scene) -> float:
    vertices = np.concatenate([scene.base_mesh.vertices, scene.relative_mesh.vertices])
    return float(np.ptp(vertices, axis=0).max())


def test_on_top_at_the_edge_hangs_clearly_over_one_side(scenes):
    for scene in scenes[Relation.ON_TOP_EDGE]:
        reach, foot, _ = overhangs(scene)
        over = (reach > 0.24 * foot) & (reach > 0.044 * extent(scene))
        assert over.any()
        # Something of the base shows on the other side.
        assert (np.roll(reach, 24)[over] < -0.018 * extent(scene)).any()


def test_on_top_the_foot_is_clearly_within_or_centred(scenes):
    for scene in scenes[Relation.ON_TOP]:
        reach, foot, support = overhangs(scene)
        off_centre = np.abs(reach - np.roll(reach, 24)) / 2.0
        within = -reach > 0.029 * extent(scene)
        assert (within | (off_centre < 0.11 * np.minimum(foot, support) + 1.5e-3)).all()


def test_inside_the_relative_is_level_within_the_walls(scenes):
    for scene in scenes[Relation.INSIDE]:
        assert scene.lean_rad < 1e-3
        rim = scene.base.body.model.opening.rim_z + scene.base.translation[2]
        below = scene.relative_points[scene.relative_points[:, 2] < rim]
        assert len(below) > 0.12 * len(scene.relative_points)
        assert share_of_hull(below, scene.base_mesh.vertices) > 0.99
        assert scene.touching[:, 2].max() < rim + 0.002


def test_inclined_stands_on_the_table_and_leans_on_the_base(scenes):
    for scene in scenes[Relation.INCLINED]:
        assert scene.relative_mesh.vertices[:, 2].min() < 1e-3
        assert scene.lean_rad > LEAST_LEAN_RAD - 1e-6
        foot = scene.relative_points[scene.relative_points[:, 2] < 0.001, :2].mean(axis=0)
        held = scene.touching[:, :2].mean(axis=0)
        towards = (held - foot) / np.linalg.norm(held - foot)
        # The weight lies between the foot and the place where it is held.
        assert (scene.relative.centre_of_mass()[:2] - foot) @ towards > 0.0


def test_inside_and_inclined_reaches_out_and_leans(scenes):
    for scene in scenes[Relation.INSIDE_INCLINED]:
        rim = scene.base.body.model.opening.rim_z + scene.base.translation[2]
        assert scene.lean_rad > LEAST_LEAN_RAD - 1e-6
        assert scene.relative_mesh.vertices[:, 2].min() < rim - 0.01
        assert np.ptp(scene.touching[:, 2]) > 0.015
        inside = scene.relative_points[scene.relative_points[:, 2] < rim]
        assert share_of_hull(inside, scene.base_mesh.vertices) > 0.9


def test_inside_lying_the_container_opens_to_the_side(scenes):
    for scene in scenes[Relation.INSIDE_LYING]:
        opening = scene.base.body.model.opening
        assert abs(scene.base.rotation[2, 2]) < 0.5
        assert opening.depth > 0.03
        assert share_of_hull(scene.relative_points, scene.base_mesh.vertices) > 0.15
        local = (scene.touching - scene.base.translation) @ scene.base.rotation
        assert (local[:, 2] < opening.rim_z + 0.002).any()


def test_same_seed_same_scene(sampler):
    first, again, other = (
        sampler.sample(Relation.INSIDE_INCLINED, np.random.default_rng(seed)) for seed in (4, 4, 5)
    )
    np.testing.assert_array_equal(
        first.measured.relative.translation, again.measured.relative.translation
    )
    assert first.rejected == again.rejected
    assert not np.array_equal(
        first.measured.relative.translation, other.measured.relative.translation
    )


def test_a_last_check_refuses_and_is_counted():
    bodies = [
        Body.of(sample_object(family, np.random.default_rng(0), name=family))
        for family in ('box', 'can')
    ]
    verdicts = iter(['moves', 'moves', ''])
    sampler = SceneSampler(bodies, check=lambda measured: next(verdicts))
    scene = sampler.sample(Relation.NEXT_TO, np.random.default_rng(0))
    assert scene.rejected['moves'] == 2
    unchecked = SceneSampler(bodies).sample(Relation.NEXT_TO, np.random.default_rng(0))
    assert unchecked.rejected['moves'] == 0


def test_impossible_requests_say_why():
    bodies = [
        Body.of(sample_object(family, np.random.default_rng(0), name=family))
        for family in ('box', 'can')
    ]
    with pytest.raises(SpatialRelationsError, match=r"no two of \['box', 'can'\] can be inside"):
        sample_scene(Relation.INSIDE, bodies, np.random.default_rng(0))


def test_nothing_is_set_down_aslant_on_a_narrow_foot():
    """Cans are laid down though they may roll; nothing balances on beak and breast."""
    rng = np.random.default_rng(3)
    may_roll = 0
    for model in generate_objects(48, seed=4):
        body = Body.of(model)
        for _ in range(6):
            pose = sample_rest_pose(body, dict.fromkeys(RestKind, 1.0), rng)
            if pose is not None and np.rad2deg(pose.tipping_angle_rad) < 7.0:
                assert abs(pose.rotation[2, 2]) < np.sin(np.deg2rad(14.0)), model.name
                may_roll += 1
    assert may_roll > 5


def test_where_the_base_lies_the_relative_lies_more_often(sampler):
    rng = np.random.default_rng(5)
    lies: dict[bool, list[bool]] = {False: [], True: []}
    for _ in range(90):
        measured = sampler.sample(Relation.NEXT_TO, rng).measured
        base, relative = (
            bool(abs(placed.rotation[2, 2]) < 0.7) for placed in (measured.base, measured.relative)
        )
        lies[base].append(relative)
    assert np.mean(lies[True]) > np.mean(lies[False])
