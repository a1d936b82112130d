import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from spatial_relations_ros.core import InvalidPoseError, Pose
from spatial_relations_ros.core.rotations import (
    matrix_from_quat_wxyz,
    quat_wxyz_from_matrix,
    wxyz_from_xyzw,
    xyzw_from_wxyz,
)

numbers = st.floats(-10.0, 10.0, allow_nan=False, width=32)
quaternions = hnp.arrays(np.float64, 4, elements=numbers).filter(
    lambda quat: np.linalg.norm(quat) > 0.1
)
vectors = hnp.arrays(np.float64, 3, elements=numbers)


@st.composite
def poses(draw):
    quat = draw(quaternions)
    return Pose(draw(vectors), quat / np.linalg.norm(quat))


def test_quarter_turn_about_z_takes_x_to_y():
    half = np.sqrt(0.5)
    world_from_object = Pose(np.array([1.0, 2.0, 3.0]), np.array([half, 0.0, 0.0, half]))
    np.testing.assert_allclose(world_from_object.apply(np.array([1.0, 0, 0])), [1, 3, 3])


@given(poses(), poses(), vectors)
def test_composition_applies_right_to_left(a_from_b, b_from_c, point):
    np.testing.assert_allclose(
        (a_from_b @ b_from_c).apply(point), a_from_b.apply(b_from_c.apply(point)), atol=1e-6
    )


@given(poses())
def test_inverse_undoes(pose):
    assert (pose @ pose.inverse()).is_close(Pose.identity())
    assert (pose.inverse() @ pose).is_close(Pose.identity())


@given(poses())
def test_matrix_round_trip(pose):
    assert Pose.from_matrix(pose.as_matrix()).is_close(pose, angle_rad=1e-5)


@given(st.permutations([0, 1, 2, 3]), quaternions)
def test_a_matrix_gives_its_quaternion_back_whichever_part_is_small(order, quat):
    # From half turns about each axis to hardly any turn.
    quat = (quat * np.array([1.0, 1e-3, 1e-6, 1e-9]))[list(order)]
    quat = quat / max(np.linalg.norm(quat), 1e-12)
    if np.linalg.norm(quat) < 0.5:
        return
    found = quat_wxyz_from_matrix(matrix_from_quat_wxyz(quat))
    assert found[0] >= 0.0
    np.testing.assert_allclose(abs(found @ quat), 1.0, atol=1e-12)


@given(quaternions)
def test_quaternion_order_round_trip(quat):
    np.testing.assert_array_equal(wxyz_from_xyzw(xyzw_from_wxyz(quat)), quat)
    assert xyzw_from_wxyz(quat)[3] == quat[0]


@given(poses())
def test_rotation_matrix_matches_the_quaternion_product(pose):
    # Hamilton's formula for the first column, written out.
    w, x, y, z = pose.quat_wxyz
    column = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)]
    np.testing.assert_allclose(matrix_from_quat_wxyz(pose.quat_wxyz)[:, 0], column, atol=1e-9)
    np.testing.assert_allclose(
        matrix_from_quat_wxyz(quat_wxyz_from_matrix(pose.rotation)), pose.rotation, atol=1e-7
    )


@pytest.mark.parametrize(
    ('translation', 'quat_wxyz', 'reason'),
    [
        ([0, 0, float('nan')], [1, 0, 0, 0], 'not finite'),
        ([0, 0, 0], [float('inf'), 0, 0, 0], 'not finite'),
        ([0, 0, 0], [0, 0, 0, 0], 'norm 0'),
        ([0, 0, 0], [2, 0, 0, 0], 'norm 2'),
        ([0, 0], [1, 0, 0, 0], 'shape'),
        (['a', 0, 0], [1, 0, 0, 0], 'numbers'),
    ],
)
def test_a_bad_pose_says_why(translation, quat_wxyz, reason):
    with pytest.raises(InvalidPoseError, match=reason):
        Pose(translation, quat_wxyz)


def test_a_quaternion_that_was_rounded_is_normalised():
    pose = Pose(np.zeros(3), np.array([0.7071, 0.7071, 0.0, 0.0]))
    assert np.linalg.norm(pose.quat_wxyz) == pytest.approx(1.0, abs=1e-12)


def test_a_reflection_is_no_pose():
    with pytest.raises(InvalidPoseError, match='not a rotation'):
        Pose.from_matrix(np.diag([1.0, 1.0, -1.0, 1.0]))
