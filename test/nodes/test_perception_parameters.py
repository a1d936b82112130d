"""Parameters of perception_node that are more than a value."""

from __future__ import annotations

import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.nodes.perception_parameters import camera_transform

pytestmark = pytest.mark.ros


def test_a_camera_pose_becomes_a_static_transform() -> None:
    transform = camera_transform('1 2 3, 0 0 1 0', 'optical', 'map')
    assert transform is not None
    assert (transform.parent_frame, transform.child_frame) == ('map', 'optical')
    assert transform.is_static
    np.testing.assert_allclose(transform.parent_from_child.apply(np.array([1.0, 0, 0])), [0, 2, 3])
    assert camera_transform(' ', '', 'map') is None


@pytest.mark.parametrize(
    ('pose', 'frame_id', 'reason'),
    [
        ('0 0 0 0 0 0 1', '', 'needs camera_frame'),
        ('0 0 0 0 0 1', 'optical', '6 numbers'),
        ('0 0 0 0 0 0 one', 'optical', 'expected "x y z qx qy qz qw"'),
        ('0 0 0 0 0 0 0', 'optical', 'norm 0'),
        ('nan 0 0 0 0 0 1', 'optical', 'not finite'),
    ],
)
def test_a_camera_pose_that_is_none_is_refused(pose: str, frame_id: str, reason: str) -> None:
    with pytest.raises(ConfigError, match=reason):
        camera_transform(pose, frame_id, 'map')
