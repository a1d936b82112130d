"""The metric node: embeddings, distances and relations that are remembered."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from demo_session import DemoSession
from spatial_relations_msgs.srv import (
    Distance,
    Embed,
    Forget,
    GetScene,
    ListRelations,
    Nearest,
    Recall,
    Remember,
)

from spatial_relations_ros.learning import load_metric
from spatial_relations_ros.ros.conversions import scene_from_msg

pytestmark = pytest.mark.ros


def test_embeddings_and_distances_are_those_of_the_metric(
    session: DemoSession, weights: Path
) -> None:
    metric = load_metric(weights)
    found = session.call(GetScene, '/perception_node/get_scene', object_ids=session.test_ids)
    by_ids = session.call(Embed, '/metric_node/embed', object_ids=session.test_ids)
    by_scene = session.call(Embed, '/metric_node/embed', scene=[found.scene])
    assert by_ids.model_hash == metric.model_hash
    expected = metric.embed_scenes([scene_from_msg(found.scene)])[0]
    # What ids name is seen anew, perhaps a frame later and some tenths of a millimetre elsewhere.
    np.testing.assert_allclose(by_ids.embedding, expected, atol=5e-3)
    np.testing.assert_allclose(by_scene.embedding, expected, atol=1e-4)
    same = session.call(
        Distance,
        '/metric_node/distance',
        reference_ids=session.test_ids,
        test_scene=[found.scene],
    )
    other = session.call(
        Distance,
        '/metric_node/distance',
        reference_ids=session.reference_ids,
        test_ids=session.test_ids,
    )
    assert same.distance == pytest.approx(0.0, abs=0.02)
    assert other.distance > 5.0 * same.distance
    # Scenes given and not seen: what else is answered is that of the metric exactly.
    given = session.call(
        Distance,
        '/metric_node/distance',
        reference_scene=[found.scene],
        test_scene=[found.scene],
    )
    scene = scene_from_msg(found.scene)
    compared = metric.compare(scene, scene)
    answered = (given.same_relation_probability, given.reference_novelty, given.test_novelty)
    np.testing.assert_allclose(
        answered, (compared.same_relation_probability, *compared.novelty), rtol=1e-3
    )
    assert (given.reference_is_novel, given.test_is_novel) == compared.is_novel
    np.testing.assert_allclose(by_scene.novelty, metric.novelty(expected), rtol=1e-3)
    assert by_scene.is_novel == compared.is_novel[0]
    wrong = session.call(Distance, '/metric_node/distance', reference_ids=session.test_ids)
    assert not wrong.success
    assert 'test: nothing is given' in wrong.message


def test_relations_are_remembered_found_imitated_and_forgotten(session: DemoSession) -> None:
    assert not session.call(Nearest, '/metric_node/nearest', object_ids=session.test_ids).success
    for name, object_ids in (('shown', session.reference_ids), ('apart', session.test_ids)):
        stored = session.call(Remember, '/metric_node/remember', name=name, object_ids=object_ids)
        assert stored.success, stored.message
    again = session.call(
        Remember, '/metric_node/remember', name='shown', object_ids=session.test_ids
    )
    assert not again.success
    assert 'shown' in again.message
    listed = session.call(ListRelations, '/metric_node/list')
    assert list(listed.names) == ['apart', 'shown']
    assert list(listed.base_ids) == [session.test_ids[0], session.reference_ids[0]]
    nearest = session.call(Nearest, '/metric_node/nearest', object_ids=session.reference_ids, k=2)
    assert list(nearest.names) == ['shown', 'apart']
    assert nearest.distances[0] == pytest.approx(0.0, abs=0.02)
    recalled = session.call(Recall, '/metric_node/recall', name='shown')
    assert scene_from_msg(recalled.scene).object_ids == tuple(session.reference_ids)
    imitated = session.imitate(reference_ids=[], reference_name='shown')
    assert imitated.answers, imitated.message
    assert session.call(Forget, '/metric_node/forget', name='shown').success
    gone = session.call(Forget, '/metric_node/forget', name='shown')
    assert not gone.success
    assert "'apart'" in gone.message
