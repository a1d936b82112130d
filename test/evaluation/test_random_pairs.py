import dataclasses
import re

import numpy as np
import pytest

from spatial_relations_ros.core import Pose, Relation
from spatial_relations_ros.datasets.generator import SceneSampler, generate_objects
from spatial_relations_ros.evaluation.intervals import wilson_interval
from spatial_relations_ros.evaluation.random_pairs import rest_reason, run_cases, summarize
from spatial_relations_ros.imitation import ImitationAnswer, ObjectPlacement
from spatial_relations_ros.learning import load_metric
from spatial_relations_ros.placement.body import Body


def answer_at(base, relative):
    placements = [
        ObjectPlacement('object', Pose(), pose, pose, True, 0.0, True) for pose in (base, relative)
    ]
    return ImitationAnswer((placements[0], placements[1]), 0.0, 1.0, True, ())


@pytest.mark.parametrize('relation', [Relation.ON_TOP, Relation.INSIDE, Relation.INCLINED])
def test_generated_scenes_rest_and_lifted_or_sunk_ones_do_not(relation):
    bodies = [Body.of(model) for model in generate_objects(30, seed=2)]
    scene = SceneSampler(bodies).sample(relation, np.random.default_rng(0)).measured
    pair = scene.base.body, scene.relative.body
    base, relative = scene.base.pose(), scene.relative.pose()
    assert rest_reason(*pair, answer_at(base, relative)) == ''
    for change, reason in ((0.01, 'not stable'), (-0.05, 'penetration|below')):
        moved = dataclasses.replace(relative, translation=relative.translation + [0, 0, change])
        assert re.match(reason, rest_reason(*pair, answer_at(base, moved)))


def test_wilson_intervals_are_those_of_the_tables():
    low, high = wilson_interval(8, 10)
    assert (low, high) == (pytest.approx(0.490, abs=1e-3), pytest.approx(0.943, abs=1e-3))
    assert wilson_interval(0, 10)[0] == 0.0
    assert wilson_interval(10, 10)[1] == pytest.approx(1.0)


def test_cases_are_counted_by_relation():
    cases = run_cases(load_metric(), per_relation=1, num_objects=30, seed=2)
    summary = summarize(cases)
    assert [case.relation for case in cases] == [relation.name for relation in Relation]
    assert summary['all']['cases'] == 7
    assert summary['all']['imitated_and_at_rest'] == sum(case.is_right for case in cases)
    assert all(case.distance <= case.initial_distance for case in cases)
