"""Judging attempts: causes of failures, physics, counts, tables."""

import dataclasses
import math

import pytest

from spatial_relations_ros.core import Relation
from spatial_relations_ros.evaluation.generalization.attempt import Attempt
from spatial_relations_ros.evaluation.generalization.outcome import judge_attempt
from spatial_relations_ros.evaluation.generalization.summary import counts, summarize
from spatial_relations_ros.evaluation.generalization.tables import (
    CLAIM_COLUMNS,
    RESULT_COLUMNS,
    claim_rows,
    markdown,
    result_rows,
)

pytest.importorskip('mujoco', reason='needs MuJoCo, the extra physics')

TILTED = (math.cos(0.25), 0.0, math.sin(0.25), 0.0)


@pytest.mark.parametrize(
    ('x', 'z', 'quat', 'simulate', 'cause'),
    [
        (0.0, 0.07, (1, 0, 0, 0), True, ''),
        (0.0, 0.07, (1, 0, 0, 0), False, ''),
        (0.0, 0.066, (1, 0, 0, 0), True, ''),  # 4 mm deep is tolerated
        (0.0, 0.05, (1, 0, 0, 0), True, 'penetration'),
        (0.0, 0.12, (1, 0, 0, 0), True, 'no relation: the relative floats'),
        (0.2, 0.02, (1, 0, 0, 0), True, 'below the table'),
        (0.15, 0.03, (1, 0, 0, 0), True, 'next to instead'),
        (0.09, 0.07, (1, 0, 0, 0), True, 'on top, at a corner or edge instead'),
        (0.065, 0.07, (1, 0, 0, 0), True, 'offset'),
    ],
)
def test_causes(case, attempt_at, x, z, quat, simulate, cause):
    outcome = judge_attempt(case, 'ours', attempt_at(x, z, quat), simulate=simulate)
    assert outcome.cause == cause, outcome.differences
    assert outcome.is_right is (not cause)
    assert outcome.entry()['cause'] == cause


def test_what_falls_is_not_feasible(boxes, case, attempt_at):
    at_edge = dataclasses.replace(
        case, relation=Relation.ON_TOP_EDGE, reference=boxes[Relation.ON_TOP_EDGE]
    )
    # The centre of mass is 4 mm beyond the border: still on the edge, as far as shapes go.
    attempt = attempt_at(0.104, 0.07)
    outcome = judge_attempt(at_edge, 'ours', attempt, simulate=True)
    assert outcome.is_imitated
    assert outcome.cause == 'moved in simulation'
    assert not outcome.feasibility.in_balance
    assert outcome.feasibility.motions[1].shift > 0.02
    still = judge_attempt(at_edge, 'ours', attempt, simulate=False)
    assert still.cause == 'not in balance'
    held = judge_attempt(at_edge, 'ours', attempt_at(0.085, 0.07), simulate=True)
    assert held.is_right
    assert held.feasibility.in_balance


def test_a_frame_beside_the_object_does_not_matter(solids, boxes, case, attempt_at):
    """Simulation and contacts work about the middle of an object, wherever its origin is."""
    centred = judge_attempt(case, 'ours', attempt_at(0.0, 0.07), simulate=True)
    cube = case.test.relative
    shift = (0.5, 0.3, -0.2)
    moved = dataclasses.replace(
        cube,
        points=cube.points + shift,
        mesh=dataclasses.replace(cube.mesh, vertices=cube.mesh.vertices + shift),
    )
    beside = dataclasses.replace(case, test=dataclasses.replace(case.test, relative=moved))
    attempt = attempt_at(0.0, 0.07)
    base, relative = attempt.poses
    back = dataclasses.replace(relative, translation=relative.translation - shift)
    outcome = judge_attempt(
        beside, 'ours', dataclasses.replace(attempt, poses=(base, back)), simulate=True
    )
    assert outcome.is_right
    assert outcome.feasibility.in_balance
    for one, other in zip(outcome.feasibility.motions, centred.feasibility.motions, strict=True):
        assert one.shift == pytest.approx(other.shift, abs=1e-4)


def test_a_refusal_is_a_failure_of_its_own(case):
    attempt = Attempt(None, False, None, math.nan, math.nan, 0, 0.1, 0.1, 'objects too large')
    outcome = judge_attempt(case, 'ours', attempt, simulate=True)
    assert outcome.cause == 'refused'
    assert outcome.differences == ('objects too large',)
    assert 'poses' not in outcome.entry()
    assert attempt.scene(case) is case.test


@pytest.fixture
def outcomes(case, attempt_at):
    """Of five attempts of ours two are right, of which one is claimed; one of another variant."""
    places = [
        (0.0, 0.07, True), (0.0, 0.05, True), (0.0, 0.12, False), (0.15, 0.03, False),
        (0.01, 0.07, False),
    ]  # fmt: skip
    made = [
        judge_attempt(
            dataclasses.replace(case, number=number),
            'ours',
            attempt_at(x, z, claimed=claimed),
            simulate=False,
        )
        for number, (x, z, claimed) in enumerate(places)
    ]
    other = dataclasses.replace(attempt_at(0.15, 0.03), claimed=None)
    return [
        *made,
        judge_attempt(dataclasses.replace(case, number=4), 'features', other, simulate=False),
    ]


def test_counts(outcomes):
    counted = counts(outcomes[:5])
    assert {
        name: (counted[name]['hits'], counted[name]['of'])
        for name in (
            'same_class', 'imitated', 'feasible', 'right', 'claimed', 'claimed_right',
            'unclaimed_right',
        )
    } == {
        'same_class': (2, 5), 'imitated': (2, 5), 'feasible': (3, 5), 'right': (2, 5),
        'claimed': (2, 5), 'claimed_right': (1, 2), 'unclaimed_right': (1, 3),
    }  # fmt: skip
    assert counted['right']['wilson_95'] == pytest.approx([0.1176, 0.7693], abs=1e-4)


def test_summaries_and_tables(outcomes):
    ours, features = summarize(outcomes)
    assert ours['failures'] == {
        'next to instead': 1, 'no relation: the relative floats': 1, 'penetration': 1,
    }  # fmt: skip
    assert ours['relations'].keys() == {'all', 'on_top'}
    assert features['relations']['all']['claimed'] is None
    assert (features['first_on_same_cases']['hits'], features['first_on_same_cases']['of']) == (
        1,
        1,
    )
    rows = result_rows([ours, features])
    assert all(len(row) == len(RESULT_COLUMNS) for row in rows)
    assert rows[0][:6] == ('known', 'ours', '2 of 5', '3 of 5', '2 of 5', '40.0 % (12 to 77)')
    rows = claim_rows([ours, features])
    assert rows[0] == ('known', 'ours', '2 of 5', '2 of 5', '1 of 2', '1 of 3', '2 of 5')
    assert rows[1] == ('known', 'features', '0 of 1', '-', '-', '-', '1 of 1')
    assert all(len(row) == len(CLAIM_COLUMNS) for row in rows)
    text = markdown([ours, features])
    assert '| on top | 2 of 5 | 2 of 5 | 3 of 5 | 2 of 5 | 40.0 % (12 to 77) |' in text
    assert 'Failures: 1 next to instead.' in text
