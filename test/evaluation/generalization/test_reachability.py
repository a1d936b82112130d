import dataclasses

import numpy as np
import pytest

from spatial_relations_ros.core import Relation
from spatial_relations_ros.evaluation.generalization.reachability import (
    PlacedPair,
    measure_reachability,
    place_pairs,
)
from spatial_relations_ros.evaluation.judging import judge_scene


def test_generated_pairs_can_agree():
    pairs = place_pairs(num_pairs=2, num_placements=2, num_objects=40, seed=1)
    assert [pair.relation for pair in pairs] == [*Relation, *Relation]
    table = measure_reachability(pairs)
    assert list(table) == [relation.name.lower() for relation in Relation]
    # Each reference with the other pair; those that the judge takes for something else are out.
    compared = sum(row['pairs'] for row in table.values())
    assert 12 <= compared <= 14
    assert sum(row['reachable'] for row in table.values()) >= compared - 2


def test_what_cannot_agree_is_counted(boxes):
    judged = {relation: judge_scene(scene, 0.0) for relation, scene in boxes.items()}
    on_top, edge = judged[Relation.ON_TOP], judged[Relation.ON_TOP_EDGE]
    measures = dataclasses.replace(
        on_top.measures,
        relative_bottom=0.2,
        relative_height=0.01,
        contact_points=on_top.measures.contact_points + np.array([0.0, 0.0, 0.2]),
    )
    hovering = dataclasses.replace(on_top, measures=measures)
    pairs = [
        PlacedPair(Relation.ON_TOP, ('a', 'b'), (on_top, on_top)),
        PlacedPair(Relation.ON_TOP, ('c', 'd'), (hovering, edge)),
        PlacedPair(Relation.ON_TOP_EDGE, ('e', 'f'), (edge, on_top)),
    ]
    row = measure_reachability(pairs)['on_top']
    assert (row['reachable'], row['pairs']) == (0, 2)
    assert row['agreeing_placements'] == pytest.approx(0.0)
    # The last pair's second placement is on top and agrees with the first pair's reference.
    assert (row['other_relations_agreeing'], row['other_relations']) == (1, 4)
    assert row['differs'] == {"height over the base's top": 3, 'class': 1}
