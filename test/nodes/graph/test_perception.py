"""The perception node: scenes, markers and what else is seen, and the diagnostics of all."""

from __future__ import annotations

import itertools
import os

import numpy as np
import pytest
from demo_session import DemoSession
from spatial_relations_msgs.srv import GetScene

from spatial_relations_ros.evaluation.bag_reader import BagReader, BagTopics
from spatial_relations_ros.perception.point_cloud2 import read_xyz
from spatial_relations_ros.pipeline import LibraryModels, Pipeline
from spatial_relations_ros.ros.conversions import scene_from_msg

pytestmark = pytest.mark.ros


def test_scenes_and_markers_of_all_pairs_are_published(session: DemoSession) -> None:
    object_ids = {'plate', 'cup', 'pot', 'can', 'tray', 'basket', 'mug', 'mug_2'}
    pairs = set(itertools.permutations(object_ids, 2))
    session.graph.wait(lambda: set(session.scenes) == pairs, 'a scene of each pair')
    session.graph.wait(lambda: bool(session.markers), 'markers')
    assert {marker.text for marker in session.markers[-1].markers if marker.text} == object_ids


def test_the_live_scene_is_that_of_the_replay(session: DemoSession) -> None:
    """The node and the bag reader feed the same pipeline the same messages."""
    plan = session.plan
    pipeline = Pipeline(models=LibraryModels(plan.models_path))
    topics = BagTopics(plan.points_topic, (plan.tracked_objects_topic,))
    live = session.call(GetScene, '/perception_node/get_scene', object_ids=session.reference_ids)
    assert live.success, live.message
    scene = scene_from_msg(live.scene)
    with BagReader(plan.bag, topics) as reader:
        for frame in reader.frames():
            result = pipeline.step(frame)
            if result.stamp_ns == scene.stamp_ns:
                break
    replayed = pipeline.scene(*session.reference_ids)
    assert scene.stamp_ns == replayed.stamp_ns
    for seen, again in zip(scene.objects, replayed.objects, strict=True):
        np.testing.assert_array_equal(seen.points, again.points)
        # Which of two poses at nearly the same time came first may differ over DDS.
        assert seen.world_from_object.is_close(
            again.world_from_object, metres=0.01, angle_rad=0.05
        )
    assert live.table_height == pytest.approx(result.table_height, abs=0.01)


def test_what_else_is_seen_comes_with_a_scene_when_asked(session: DemoSession) -> None:
    plain = session.call(GetScene, '/perception_node/get_scene', object_ids=session.test_ids)
    asked = session.call(
        GetScene, '/perception_node/get_scene', object_ids=session.test_ids, with_others=True
    )
    assert not plain.others
    others = {item.object_id for item in asked.others}
    assert others == {'plate', 'cup', 'pot', 'can', 'tray', 'basket', 'mug', 'mug_2'} - set(
        session.test_ids
    )
    assert not plain.clutter.width
    clutter = read_xyz(asked.clutter).points
    assert asked.clutter.header.frame_id == session.plan.world_frame
    # What belongs to an object or to the table is left out.
    assert (clutter[:, 2] > asked.table_height).all()
    mug = scene_from_msg(asked.scene).relative.world_from_object.translation
    assert (np.linalg.norm(clutter - mug, axis=1) > 0.03).all()


def test_diagnostics_tell_rates_states_memory_and_processor_time(session: DemoSession) -> None:
    graph = session.graph
    graph.wait(lambda: 'imitate_node: model' in graph.diagnostics, 'diagnostics')
    points = graph.diagnostic('perception_node: ~/points')
    assert int(points['received']) > 5
    assert {'rate_hz', 'age_sec', 'bad'} <= points.keys()
    assert float(graph.diagnostic('metric_node: process')['memory_mb']) > 50.0
    for name in ('perception_node', 'metric_node', 'imitate_node'):
        # All threads of a process together, on all cores.
        share = float(graph.diagnostic(f'{name}: process')['cpu_percent'])
        assert 0.0 <= share <= 100.0 * os.cpu_count()
    assert len(graph.diagnostic('imitate_node: model')['sha256']) == 64
    assert graph.diagnostic('imitate_node: standalone')['message'] == 'off'
