"""Scenes out of results, and what is said of objects that are not there."""

import numpy as np
import pytest

from spatial_relations_ros.core import InvalidSceneError, Pose, SceneObject, UnknownObjectError
from spatial_relations_ros.perception.border import FrameResult

POINTS = np.random.default_rng(0).random((10, 3)).astype(np.float32)


def result(**changes):
    objects = {name: SceneObject(name, POINTS, Pose()) for name in ('cup', 'plate')}
    fields = {'objects': objects, 'rejected': {'mug': 'the last tracked pose is 2.30 s old'}}
    return FrameResult(7, 'world', **(fields | changes))


def test_a_scene_keeps_order_stamp_and_frame():
    scene = result().scene('plate', 'cup')
    assert scene.object_ids == ('plate', 'cup')
    assert (scene.stamp_ns, scene.frame_id) == (7, 'world')


def test_says_why_an_object_is_missing_and_which_are_known():
    with pytest.raises(UnknownObjectError, match=r'mug: .* 2.30 s old; known objects: cup, plate'):
        result().scene('plate', 'mug')
    with pytest.raises(UnknownObjectError, match='ghost: no tracked pose has arrived; known'):
        result().scene('ghost', 'cup')
    blind = result(objects={}, rejected={}, problem='no finite points')
    with pytest.raises(UnknownObjectError, match='cup: no finite points; known objects: none'):
        blind.scene('cup', 'plate')


def test_an_object_has_no_relation_to_itself():
    with pytest.raises(InvalidSceneError, match="'cup' twice"):
        result().scene('cup', 'cup')
