"""Convex parts, and what stays put or falls in simulation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from spatial_relations_ros.core import ConfigError, TriangleMesh
from spatial_relations_ros.datasets.objects import sample_object
from spatial_relations_ros.datasets.objects.model_of_solid import model_of_solid
from spatial_relations_ros.datasets.objects.solids import box, prism
from spatial_relations_ros.placement.body import Body, Placed
from spatial_relations_ros.placement.convex_parts import convex_parts
from spatial_relations_ros.placement.physics import settle
from spatial_relations_ros.placement.ray_casting import as_tensor, ray_casting_scene
from spatial_relations_ros.placement.resting import about_axis

SIDE = 0.1


def body_of(solid) -> Body:
    return Body.of(model_of_solid('test', solid, {}))


@pytest.fixture(scope='module')
def cube() -> Body:
    return body_of(box((SIDE, SIDE, SIDE)))


def at(body: Body, translation, rotation=None) -> Placed:
    return Placed(body, np.eye(3) if rotation is None else rotation, np.array(translation))


def test_a_cube_is_one_part(cube):
    (part,) = cube.convex_parts
    assert part.filled == pytest.approx(1.0)
    assert ConvexHull(part.points).volume == pytest.approx(SIDE**3, rel=1e-4)


def test_an_l_is_two_boxes():
    ell = body_of(
        prism([(0, 0), (0.1, 0), (0.1, 0.02), (0.02, 0.02), (0.02, 0.1), (0, 0.1)], 0.05)
    )
    volumes = [ConvexHull(part.points).volume for part in ell.convex_parts]
    assert len(volumes) == 2
    assert sum(volumes) == pytest.approx(0.05 * (0.1 * 0.02 + 0.02 * 0.08), rel=5e-3)


def test_parts_of_a_box_without_a_lid_leave_its_room_free():
    model = sample_object('boxbase', np.random.default_rng(0))
    parts = convex_parts(model.mesh)
    solid = model.mass_properties.mass / model.density
    assert sum(ConvexHull(part.points).volume for part in parts) < 1.05 * solid
    for part in parts:
        hull = ConvexHull(part.points)
        middle = hull.equations[:, :3] @ np.zeros(3) + hull.equations[:, 3]
        assert middle.max() > 0.0


@pytest.mark.parametrize('family', ['mug', 'bakingdish', 'bowl'])
def test_parts_hardly_reach_into_a_hollow_with_rounded_walls(family):
    model = sample_object(family, np.random.default_rng(2))
    surface = ray_casting_scene(model.mesh)
    # Corners of the hulls lie on the solid; the middles of their faces show what bulges.
    middles = []
    for part in convex_parts(model.mesh):
        hull = ConvexHull(part.points)
        middles.append(part.points[hull.simplices].mean(axis=1))
    distances = surface.compute_signed_distance(as_tensor(np.concatenate(middles))).numpy()
    assert distances.max() < 0.006


def test_an_open_surface_has_no_parts():
    mesh = TriangleMesh(np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], dtype=np.int32))
    with pytest.raises(ConfigError, match='watertight'):
        convex_parts(mesh)


class TestSettling:
    """Needs MuJoCo."""

    @pytest.fixture(autouse=True)
    def _mujoco(self):
        pytest.importorskip('mujoco')

    def test_a_stack_stays(self, cube):
        motions = settle([at(cube, [0, 0, 0.05]), at(cube, [0.03, 0.01, 0.15])])
        assert all(motion.stayed for motion in motions)
        assert max(motion.shift for motion in motions) < 0.002

    def test_what_hangs_over_too_far_falls(self, cube):
        _, above = settle([at(cube, [0, 0, 0.05]), at(cube, [0.07, 0.0, 0.15])])
        assert not above.stayed
        assert above.turn_rad > 0.5

    def test_what_floats_drops(self, cube):
        (motion,) = settle([at(cube, [0, 0, 0.1])])
        assert motion.shift == pytest.approx(0.05, abs=0.005)
        assert motion.turn_rad < 0.05

    def test_friction_decides_on_a_slope(self):
        wedge = body_of(prism([(0, 0), (0.3, 0), (0.3, 0.15)], 0.2))
        slope = np.arctan2(0.15, 0.3)
        rotation = about_axis(np.array([0.0, 1.0, 0.0]), -slope)
        small = body_of(box((0.04, 0.04, 0.02)))
        middle = np.array([0.0, 0.0, 0.075]) + 0.0101 * np.array(
            [-np.sin(slope), 0, np.cos(slope)]
        )
        scene = [at(wedge, [0, 0, 0.075]), at(small, middle, rotation)]
        rough, smooth = (settle(scene, friction=friction)[1] for friction in (0.8, 0.2))
        assert rough.stayed
        assert not smooth.stayed
