"""Variants on cases, in one process and in several; pictures."""

import dataclasses

import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError, Relation
from spatial_relations_ros.evaluation.generalization.cases import Case
from spatial_relations_ros.evaluation.generalization.feature_search import search_by_features
from spatial_relations_ros.evaluation.generalization.outcome import judge_attempt
from spatial_relations_ros.evaluation.generalization.running import Runner, Settings, jobs_of
from spatial_relations_ros.evaluation.generalization.variants import (
    VARIANTS,
    Weights,
    check_variants,
    options_of,
)
from spatial_relations_ros.evaluation.generalization.views import (
    CaseView,
    failures_first,
    write_sheets,
)
from spatial_relations_ros.imitation import ImitationOptions
from spatial_relations_ros.visualization import read_image

pytest.importorskip('mujoco', reason='needs MuJoCo, the extra physics')


@pytest.fixture(scope='module')
def cases(boxes):
    return [
        Case(number, 'known', relation, boxes[relation], boxes[Relation.NEXT_TO], 'shown', 'test')
        for number, relation in enumerate((Relation.ON_TOP, Relation.ON_TOP_EDGE))
    ]


def without_times(outcome):
    entry = outcome.entry()
    del entry['seconds'], entry['cpu_seconds']
    return entry


def test_any_number_of_processes_gives_the_same(cases):
    assert jobs_of(cases, ['ours', 'features'], 1) == [('ours', 0), ('ours', 1), ('features', 0)]
    jobs = [('features', 1), ('no-gradient', 0)]
    found = []
    for num_jobs in (1, 2):
        seen = []
        with Runner(cases, Settings(Weights()), num_jobs=num_jobs).started() as runner:
            outcomes = runner.run(jobs, lambda done, total, seen=seen: seen.append((done, total)))
            views = runner.draw([(idx, out) for (_, idx), out in zip(jobs, outcomes, strict=True)])
        assert seen == [(1, 2), (2, 2)]
        assert [(outcome.variant, outcome.number) for outcome in outcomes] == jobs
        assert [view.picture.shape for view in views] == [(150, 600, 3)] * 2
        found.append([without_times(outcome) for outcome in outcomes])
        assert all(entry['distance'] <= entry['initial_distance'] for entry in found[-1])
    assert found[0] == found[1]


def test_variants_differ_from_the_defaults_in_what_they_are_named_for():
    assert options_of('ours') == ImitationOptions()
    assert options_of('no-gradient').max_steps == 0
    assert options_of('no-proposals').propose is False
    assert options_of('no-physics').physics_weight == 0.0
    assert options_of('one-start').num_starts == 1
    assert options_of('one-rate').learning_rate_spread == 1.0
    assert options_of('soft').soft_refinement
    paper = options_of('paper')
    assert (paper.max_steps, paper.num_starts, paper.physics_weight) == (600, 1, 0.0)
    assert check_variants(['paper', 'ours', 'paper']) == ('paper', 'ours')
    assert check_variants(VARIANTS) == VARIANTS
    with pytest.raises(ConfigError, match="'papers'; there are ours, paper"):
        check_variants(['ours', 'papers'])
    with pytest.raises(ConfigError, match='no variant at all'):
        check_variants([])


def test_the_feature_search_comes_nearer_and_leaves_the_base(cases):
    attempt = search_by_features(cases[0], seed=4)
    again = search_by_features(cases[0], seed=4)
    base, relative = attempt.poses
    assert base is cases[0].test.base.world_from_object
    np.testing.assert_array_equal(relative.as_matrix(), again.poses[1].as_matrix())
    assert attempt.distance < 0.5 * attempt.initial_distance
    lowest = relative.apply(cases[0].test.relative.mesh.vertices)[:, 2].min()
    assert lowest > -0.01


def test_failures_are_drawn_first(tmp_path, case, attempt_at):
    places = [(0.0, 0.07), (0.15, 0.03), (0.0, 0.12), (0.16, 0.03)]
    views = []
    for number, (x, z) in enumerate(places):
        numbered = dataclasses.replace(case, number=number)
        outcome = judge_attempt(numbered, 'ours', attempt_at(x, z), simulate=False)
        views.append(CaseView(np.full((15, 60, 3), 40 * number, np.uint8), outcome))
    assert [view.outcome.number for view in failures_first(views)] == [1, 3, 2, 0]
    assert views[0].caption == '0 on top: right'
    assert views[1].caption == '1 on top: next to instead'
    (path,) = write_sheets(tmp_path, views)
    assert path.name == 'known_ours_01.png'
    assert read_image(path).shape[2] == 3
